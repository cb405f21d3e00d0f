"""Program document from manual changes, checked like any other document."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from cbdsl.checking.safety_net import check_safely
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostic import Diagnostic
from cbdsl.diagnostics.legible_text import encoded
from cbdsl.documents.document import NAME_PATTERN
from cbdsl.documents.program import ProgramDocument
from cbdsl.yaml_text.composer import compose
from cbdsl.yaml_text.library import Library
from cbdsl.yaml_text.reader import formatted_text
from cbdsl.yaml_text.writer import dump_plain

_WORD = re.compile(r"[^\W\d]\w*")
# Keys that refer to states of the previous actions, which no longer exist.
_OF_STATES = ("use", "steps", "start", "success", "failure", "rewards")

Plain = dict[str, Any]


class Changes(NamedTuple):
    """Manual changes, as made by ``Composer``."""

    gains: Mapping[str, float]
    targets: Mapping[str, Sequence[float]]
    stack: Sequence[str] | None


class ComposedProgram(NamedTuple):
    """Document that can be saved.

    Attributes:
        text: Text of the document.
        diagnostics: Diagnostics of the checker, with the document beside the original program.
        left_out: Controllers of other programs, whose changes it cannot hold.
    """

    text: str
    diagnostics: tuple[Diagnostic, ...]
    left_out: tuple[str, ...]


def composed_program(
    file: Path, stage: str, values: Mapping[str, str], changes: Changes, name: str
) -> ComposedProgram:
    """Return a program with manual changes.

    Args:
        file: Changed program.
        stage: Stage on which it ran.
        values: Values of its parameters and roles.
        changes: Changes to the program.
        name: Name of the new program.

    Raises:
        ValueError: The name is invalid for a program.
    """
    if not re.fullmatch(NAME_PATTERN, name) or "\n" in name:
        raise ValueError(f"'{name}' is not a name of a program: letters, digits and _")
    source = _plain(Library().text(file), str(file))
    before, controllers = source.get("name", ""), dict(source["controllers"])
    left_out = []
    # A page also changes controllers of used programs; this document defines its own alone.
    for each in dict.fromkeys([*changes.gains, *changes.targets]):
        if not isinstance(controllers.get(each), dict):
            left_out.append(each)
            continue
        changed = controllers[each] = dict(controllers[each])
        if each in changes.gains:
            changed["gain"] = f"{changes.gains[each]:.6g} /s"
        if each in changes.targets:
            changed["reference"] = [f"{value:.4f} m" for value in changes.targets[each]]
    made: Plain = {**source, "name": name, "stage": stage, "controllers": controllers}
    # Roles are bound when a program runs; the description states their parts.
    roles = source.get("roles", {})
    bound = ", ".join(f"{key}={value}" for key, value in values.items() if key in roles)
    made["description"] = f"Composed by hand from {before} while it ran{bound and ' with '}{bound}."
    if "parameters" in source:
        own = {key: value for key, value in values.items() if key not in roles}
        made["parameters"] = {**source["parameters"], **own}
    if changes.stack is not None:
        made = _only(made, changes.stack)
    text = dump_plain({key: made[key] for key in _ordered(made)})
    text = formatted_text(text, name)
    return ComposedProgram(text, _checked(text, file.with_name(f"{name}.yaml")), tuple(left_out))


def _plain(text: str, file: str) -> Plain:
    plain = compose(text, file).root.plain()
    assert isinstance(plain, dict), "a program that runs has been read before"
    return plain


def _only(source: Plain, stack: Sequence[str]) -> Plain:
    """Return a program with a stack as its only action, and the definitions that it needs."""
    # The stack begins with the highest priority, and the operator names it last.
    action = " ◁ ".join(reversed(stack))
    made = {key: value for key, value in source.items() if key not in _OF_STATES}
    needed = _needed(source["controllers"], f"{action} {source.get('background', '')}")
    made["controllers"] = {k: v for k, v in source["controllers"].items() if k in needed}
    # Each controller is an action as well, so that the states include all of them.
    made["actions"] = list(dict.fromkeys([*reversed(stack), action]))
    # One pattern matches all states, so that the stack runs until a time limit.
    made["policy"] = {"*" * len(stack): action}
    read = {word for key in ("controllers", "background") for word in _words(made.get(key))}
    for key in ("parameters", "resources", "models"):
        items = made.get(key, {}).items()
        made[key] = {k: v for k, v in items if key == "resources" or k in read}
    names = set(made["parameters"])
    made["resources"] = {
        group: own
        for group, members in made["resources"].items()
        if (own := {k: v for k, v in members.items() if k in names})
    }
    return {key: value for key, value in made.items() if value not in ({}, [])}


def _needed(controllers: Plain, text: str) -> set[str]:
    """Return controllers that a text names, and their dependencies."""
    # An accidental match of a name keeps a definition too many, which is harmless.
    needed, waiting = set[str](), [text]
    while waiting:
        for word in _words(waiting.pop()):
            if word in controllers and word not in needed:
                needed.add(word)
                waiting.append(" ".join(_words(controllers[word])))
    return needed


def _words(value: object) -> list[str]:
    """Return the words of all texts in a value."""
    if isinstance(value, dict):
        return [word for each in value.values() for word in _words(each)]
    if isinstance(value, list):
        return [word for each in value for word in _words(each)]
    return _WORD.findall(value) if isinstance(value, str) else []


def _ordered(made: Plain) -> list[str]:
    """Return keys in the order used in programs."""
    order = ["cbdsl", "kind", *(f.alias or n for n, f in ProgramDocument.model_fields.items())]
    return sorted(made, key=lambda key: order.index(key) if key in order else len(order))


def _checked(text: str, file: Path) -> tuple[Diagnostic, ...]:
    return tuple(check_safely(file, Session(Library(given={file: encoded(text)}))))
