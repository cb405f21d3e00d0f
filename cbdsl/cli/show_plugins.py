"""``cb show`` of everything that packages can add: built-in entries and theirs."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from cbdsl.cli.options import Json

if TYPE_CHECKING:
    from cbdsl.types.registry import Registry


def show_learners(as_json: Json = False) -> None:
    """The algorithms of cb learn and their constants."""
    from cbdsl.cli.plugins import warn_of_faults
    from cbdsl.cli.simulation import needing_simulation
    from cbdsl.cli.terminal import print_json, print_table
    from cbdsl.documents.json_schema import meaning, properties

    with needing_simulation():
        from cbdsl.learning.learner import LEARNERS, first_line

        warn_of_faults(LEARNERS)
        learners = LEARNERS.all()
    constants = {
        name: [
            {"constant": key, "default": value.get("default"), **_described(meaning(value))}
            for key, value in properties(learner.Constants).items()
        ]
        for name, learner in learners.items()
    }
    rows = [
        {"learner": name, "package": LEARNERS.package(name), "algorithm": first_line(learner)}
        for name, learner in learners.items()
    ]
    if as_json:
        print_json([{**row, "constants": constants[str(row["learner"])]} for row in rows])
        return
    print_table("Learners", rows)
    for name, declared in constants.items():
        table = [{**each, "default": _shown(each["default"])} for each in declared]
        print_table(f"Constants of {name}", table)


def show_kinds(as_json: Json = False) -> None:
    """The kinds of documents, and where each is looked up by name."""
    from cbdsl.documents.kinds import KINDS

    _show("Kinds of documents", KINDS, as_json, lambda name: {"folder": KINDS.get(name).folder})


def show_sources(as_json: Json = False) -> None:
    """The kinds of sensors that packages add, for robots' documents."""
    from cbdsl.robot.source_kind import SOURCES

    _show("Kinds of sensors", SOURCES, as_json, lambda n: {"summary": SOURCES.get(n).summary})


def show_modifiers(as_json: Json = False) -> None:
    """The changes of controllers' references that packages add, for programs."""
    from cbdsl.types.modifier import MODIFIERS

    _show("Modifiers", MODIFIERS, as_json, lambda n: {"summary": MODIFIERS.get(n).summary})


def show_backends(as_json: Json = False) -> None:
    """The bodies that programs run on."""
    from cbdsl.cli.simulation import needing_simulation

    with needing_simulation():
        from cbdsl.backends.backend import BACKENDS
    _show("Backends", BACKENDS, as_json, lambda _: {})


def _show(
    title: str, registry: Registry[Any], as_json: bool, more: Callable[[str], dict[str, str]]
) -> None:
    """Entries of a registry that can be used, their packages, and more of each."""
    from cbdsl.cli.plugins import warn_of_faults
    from cbdsl.cli.terminal import print_json, print_table

    warn_of_faults(registry)
    rows = [
        {registry.noun: name, "package": registry.package(name), **more(name)}
        for name in registry.usable_names()
    ]
    if as_json:
        print_json(rows)
    else:
        print_table(title, rows)


def _described(described: tuple[str, str]) -> dict[str, str]:
    words, unit = described
    return {"unit": unit, "meaning": words}


def _shown(value: object) -> object:
    return "" if value is None else value
