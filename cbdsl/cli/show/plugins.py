"""``cb show`` of extensible registries: built-in entries, and entries of packages."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from cbdsl.cli.episodes.simulation import needing_simulation
from cbdsl.cli.output.terminal import print_json, print_table, warn_of_faults
from cbdsl.cli.show.formats import PLAIN, Format, Json, PlainFormat, read_format
from cbdsl.documents.json_schema import meaning, properties
from cbdsl.documents.kinds import KINDS
from cbdsl.robot.driver_kind import DRIVERS
from cbdsl.robot.source_kind import SOURCES
from cbdsl.types.modifier import MODIFIERS

if TYPE_CHECKING:
    from cbdsl.types.registry import Registry


def show_learners(format_: PlainFormat = "text", as_json: Json = False) -> None:
    """Show the algorithms of cb learn and their constants."""
    form = read_format(format_, as_json, PLAIN)
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
    if form is Format.JSON:
        print_json([{**row, "constants": constants[str(row["learner"])]} for row in rows])
        return
    print_table("Learners", rows)
    for name, declared in constants.items():
        table = [{**each, "default": _shown(each["default"])} for each in declared]
        print_table(f"Constants of {name}", table)


def show_kinds(format_: PlainFormat = "text", as_json: Json = False) -> None:
    """Show the kinds of documents and the folders of their names."""
    form = read_format(format_, as_json, PLAIN)
    _show("Kinds of documents", KINDS, form, lambda name: {"folder": KINDS.get(name).folder})


def show_sources(format_: PlainFormat = "text", as_json: Json = False) -> None:
    """Show the kinds of sensors from other packages, for robot documents."""
    form = read_format(format_, as_json, PLAIN)
    _show("Kinds of sensors", SOURCES, form, lambda n: {"summary": SOURCES.get(n).summary})


def show_drivers(format_: PlainFormat = "text", as_json: Json = False) -> None:
    """Show the kinds of drivers, for robot documents."""
    form = read_format(format_, as_json, PLAIN)
    _show("Kinds of drivers", DRIVERS, form, lambda n: {"summary": DRIVERS.get(n).summary})


def show_modifiers(format_: PlainFormat = "text", as_json: Json = False) -> None:
    """Show the modifiers of controllers' references from other packages, for programs."""
    form = read_format(format_, as_json, PLAIN)
    _show("Modifiers", MODIFIERS, form, lambda n: {"summary": MODIFIERS.get(n).summary})


def show_backends(format_: PlainFormat = "text", as_json: Json = False) -> None:
    """Show the backends, and the missing packages of each."""
    form = read_format(format_, as_json, PLAIN)
    with needing_simulation():
        from cbdsl.backends.backend import BACKENDS
    _show("Backends", BACKENDS, form, _backend)


def _show(
    title: str, registry: Registry[Any], form: Format, more: Callable[[str], dict[str, str]]
) -> None:
    """Print the usable entries of a registry, with their packages and further columns."""
    warn_of_faults(registry)
    rows = [
        {registry.noun: name, "package": registry.package(name), **more(name)}
        for name in registry.usable_names()
    ]
    if form is Format.JSON:
        print_json(rows)
    else:
        print_table(title, rows)


def _backend(name: str) -> dict[str, str]:
    """Return the summary of a backend, or the reason why it cannot be used here."""
    from cbdsl.backends.backend import BackendError, find_backend

    try:
        # A backend with missing packages stays in the table, with its remedy.
        factory = find_backend(name)
    except BackendError as error:
        return {"summary": str(error)}
    return {"summary": (factory.__doc__ or "").strip().partition("\n")[0]}


def _described(described: tuple[str, str]) -> dict[str, str]:
    words, unit = described
    return {"unit": unit, "meaning": words}


def _shown(value: object) -> object:
    return "" if value is None else value
