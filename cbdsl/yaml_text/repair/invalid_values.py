"""Conversion of pydantic's errors into located diagnostics, one for each mistake."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from pydantic import BaseModel
from pydantic_core import ErrorDetails

from cbdsl.diagnostics.diagnostic import Diagnostic
from cbdsl.diagnostics.nearest import nearest_name
from cbdsl.diagnostics.wording import diagnose
from cbdsl.yaml_text.repair.invalid_value import InvalidValue, diagnose_value
from cbdsl.yaml_text.repair.schema_shape import SchemaShape
from cbdsl.yaml_text.repair.sketch import form
from cbdsl.yaml_text.source_map import SourceMap, Step, child_of


# One mistake often gives several errors: pydantic reports one for each member of a union, and one
# for each consequence. They are reduced as follows. An error about a whole value yields to an error
# inside that value. An error that follows from an omitted or respelt part is dropped. A missing key
# is dropped if an unknown key beside it has a similar name. A section without its name replaces all
# errors below it. Of the items of a list without names, only the first is reported. The remaining
# errors of one value form one diagnostic.
def diagnostics_of(
    errors: Iterable[ErrorDetails],
    source: SourceMap,
    model: type[BaseModel],
    follows: Callable[[tuple[Step, ...], str], bool],
) -> list[Diagnostic]:
    """Return one diagnostic for each invalid value, even if it fails several members of a union.

    Args:
        errors: Errors of pydantic.
        source: Source map of the document.
        model: Model of the kind of document.
        follows: Predicate that is true if an error of a type at a path only follows from another.
    """
    every = [InvalidValue(path_of(error, source), error) for error in errors]
    enclosing = {fault.path[:depth] for fault in every for depth in range(len(fault.path))}
    by_path: dict[tuple[Step, ...], list[InvalidValue]] = {}
    for fault in every:
        is_known = follows(fault.path, fault.error["type"])
        if not (is_known or (fault.is_of_parts and fault.path in enclosing)):
            by_path.setdefault(fault.path, []).append(fault)
    nameless = {path[:-1] for path in by_path if _is_nameless(path[:-1], source, model)}
    explained = _misspelt(by_path) | {p for p in by_path if _is_below(p, nameless)}
    explained |= _numbered_again(by_path)
    return [
        *(_without_a_name(path, source, model) for path in sorted(nameless)),
        *(
            diagnose_value(p, same, source, model)
            for p, same in by_path.items()
            if p not in explained
        ),
    ]


def _numbered_again(
    by_path: Mapping[tuple[Step, ...], list[InvalidValue]],
) -> set[tuple[Step, ...]]:
    """Return the further items of lists in which an item without a name is already reported."""
    seen: set[tuple[Step, ...]] = set()
    again: set[tuple[Step, ...]] = set()
    for path, same in by_path.items():
        if path and isinstance(path[-1], int) and same[0].error["type"] == "not_named":
            if path[:-1] in seen:
                again.add(path)
            seen.add(path[:-1])
    return again


def _is_nameless(path: tuple[Step, ...], source: SourceMap, model: type[BaseModel]) -> bool:
    """Return whether a mapping of names directly holds the keys of an entry instead."""
    value, shape = source.node(path).value, SchemaShape((model,)).at(path)
    keys = shape.child("").keys
    if not (shape.is_of_names and keys and isinstance(value, dict)):
        return False
    # A section may have the same name as one of the keys below it.
    are_sections = all(isinstance(node.value, dict) for node in value.values())
    return keys.keys() >= value.keys() and not are_sections


def _is_below(path: tuple[Step, ...], above: set[tuple[Step, ...]]) -> bool:
    return any(path[:depth] in above for depth in range(len(path)))


def _without_a_name(
    path: tuple[Step, ...], source: SourceMap, model: type[BaseModel]
) -> Diagnostic:
    """Return the diagnostic of a section without its name."""
    value = source.node(path).value
    keys = ", ".join(f"'{key}'" for key in value) if isinstance(value, dict) else ""
    expected = f"names, as in {form(model, path)}"
    return diagnose("CB204", source.key(*path), expected=expected, found=f"{keys} without a name")


def _misspelt(by_path: Mapping[tuple[Step, ...], list[InvalidValue]]) -> set[tuple[Step, ...]]:
    """Return the missing keys that are present under misspelt names."""
    unknown: dict[tuple[Step, ...], list[str]] = {}
    for path, same in by_path.items():
        if any(fault.error["type"] == "extra_forbidden" for fault in same):
            unknown.setdefault(path[:-1], []).append(str(path[-1]))
    return {
        path
        for path, same in by_path.items()
        if path and same[0].error["type"] == "missing"
        if nearest_name(str(path[-1]), unknown.get(path[:-1], ()))
    }


def path_of(error: ErrorDetails, source: SourceMap) -> tuple[Step, ...]:
    """Return the steps of an error's ``loc`` that exist in the text, plus a missing final key."""
    node, path = source.root, []
    for step in error["loc"]:
        child = child_of(node, step)
        if child is not None:
            node = child
            path.append(step)
    if error["type"] == "missing" and isinstance(node.value, dict):
        path.append(error["loc"][-1])
    return tuple(path)
