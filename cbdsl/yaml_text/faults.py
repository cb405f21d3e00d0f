"""From what pydantic finds in a document to located diagnostics."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import PurePath
from typing import Any, NamedTuple

from pydantic import BaseModel
from pydantic_core import ErrorDetails

from cbdsl.documents.document import NAME_PATTERN
from cbdsl.errors.counting import count
from cbdsl.errors.diagnostic import Diagnostic
from cbdsl.errors.nearest import nearest_name
from cbdsl.errors.wording import diagnostic
from cbdsl.types.unit import QuantityError
from cbdsl.yaml_text.comma import decimal_comma
from cbdsl.yaml_text.form import form
from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.shape import Shape
from cbdsl.yaml_text.source_map import SourceMap, Step, child_of

_EXPECTED = {
    "model_type": "a mapping",
    "dict_type": "a mapping",
    "tuple_type": "a list",
    "string_type": "text",
    "int_type": "an integer",
    "int_parsing": "an integer",
    "int_from_float": "an integer",
    "float_type": "a number",
    "float_parsing": "a number",
    "bool_type": "true or false",
    "bool_parsing": "true or false",
}


_PROBLEMS = {
    "greater_than": "it has to be greater than {gt:g}",
    "greater_than_equal": "it has to be at least {ge:g}",
    "less_than": "it has to be less than {lt:g}",
    "less_than_equal": "it has to be at most {le:g}",
    "too_short": "{actual_length} given, at least {min_length} needed",
    "too_long": "{actual_length} given, at most {max_length} possible",
}
#: What the values of a list are that always has as many.
_PARTS = {
    "offset": "x, y, z",
    "position": "x, y, z",
    "size": "x, y, z",
    "color": "red, green, blue",
}
_MANY = (dict, list)
_KEY_AND_VALUE = re.compile(r"(\w+)(:?) *(?:&\w+ +)?[-{\[*]")
_OF_KEYS = ("extra_forbidden", "string_pattern_mismatch")


class _Fault(NamedTuple):
    """One of pydantic's errors at the path that the text really has."""

    path: tuple[Step, ...]
    error: ErrorDetails

    @property
    def is_wrong_kind(self) -> bool:
        return self.error["type"] in (*_EXPECTED, "not_named")

    @property
    def expected(self) -> str:
        """What a value of the right kind is."""
        kind, context = self.error["type"], self.error.get("ctx", {})
        return str(context["expected"]) if kind == "not_named" else _EXPECTED[kind]

    @property
    def is_of_parts(self) -> bool:
        """Whether it may be there only because of a fault inside, which says more."""
        is_whole = self.error["type"] == "value_error" and isinstance(self.error["input"], _MANY)
        return self.is_wrong_kind or is_whole or self.error["type"] == "too_short"


def faults(
    errors: Iterable[ErrorDetails],
    source: SourceMap,
    model: type[BaseModel],
    follows: Callable[[tuple[Step, ...], str], bool],
) -> list[Diagnostic]:
    """One diagnostic for each value that is wrong, however many ways of a union it failed.

    Args:
        errors: what pydantic found.
        source: the text.
        model: the kind of document.
        follows: whether an error of a type at a path is there only because of another one.
    """
    found = [_Fault(path_of(error, source), error) for error in errors]
    enclosing = {fault.path[:depth] for fault in found for depth in range(len(fault.path))}
    by_path: dict[tuple[Step, ...], list[_Fault]] = {}
    for fault in found:
        is_known = follows(fault.path, fault.error["type"])
        if not (is_known or (fault.is_of_parts and fault.path in enclosing)):
            by_path.setdefault(fault.path, []).append(fault)
    nameless = {path[:-1] for path in by_path if _is_nameless(path[:-1], source, model)}
    explained = _misspelt(by_path) | {p for p in by_path if _is_below(p, nameless)}
    explained |= _numbered_again(by_path)
    return [
        *(_without_a_name(path, source, model) for path in sorted(nameless)),
        *(_diagnose(p, same, source, model) for p, same in by_path.items() if p not in explained),
    ]


def _numbered_again(by_path: Mapping[tuple[Step, ...], list[_Fault]]) -> set[tuple[Step, ...]]:
    """Further items of lists in which something else than a name was reported already."""
    seen: set[tuple[Step, ...]] = set()
    again: set[tuple[Step, ...]] = set()
    for path, same in by_path.items():
        if path and isinstance(path[-1], int) and same[0].error["type"] == "not_named":
            if path[:-1] in seen:
                again.add(path)
            seen.add(path[:-1])
    return again


def _is_nameless(path: tuple[Step, ...], source: SourceMap, model: type[BaseModel]) -> bool:
    """Whether where names are wanted there is what should be below one of them."""
    found, shape = source.node(path).value, Shape((model,)).at(path)
    keys = shape.child("").keys
    if not (shape.is_of_names and keys and isinstance(found, dict)):
        return False
    # A section may well be named like one of the keys below it.
    are_sections = all(isinstance(node.value, dict) for node in found.values())
    return keys.keys() >= found.keys() and not are_sections


def _is_below(path: tuple[Step, ...], above: set[tuple[Step, ...]]) -> bool:
    return any(path[:depth] in above for depth in range(len(path)))


def _without_a_name(
    path: tuple[Step, ...], source: SourceMap, model: type[BaseModel]
) -> Diagnostic:
    """What is to be said of a section that stands where it should have a name."""
    found = source.node(path).value
    keys = ", ".join(f"'{key}'" for key in found) if isinstance(found, dict) else ""
    expected = f"names, as in {form(model, path)}"
    return diagnostic("CB204", source.key(*path), expected=expected, found=f"{keys} without a name")


def _misspelt(by_path: Mapping[tuple[Step, ...], list[_Fault]]) -> set[tuple[Step, ...]]:
    """Keys that are missing because they are there under names that are nearly right."""
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
    """The steps of an error's ``loc`` that the text has, and the missing key at its end."""
    node, path = source.root, []
    for step in error["loc"]:
        child = child_of(node, step)
        if child is not None:
            node = child
            path.append(step)
    if error["type"] == "missing" and isinstance(node.value, dict):
        path.append(error["loc"][-1])
    return tuple(path)


def _diagnose(
    path: tuple[Step, ...], same: list[_Fault], source: SourceMap, model: type[BaseModel]
) -> Diagnostic:
    if row := _row(path, same, source, model):
        return row
    if all(fault.is_wrong_kind for fault in same):
        expected = " or ".join(dict.fromkeys(fault.expected for fault in same))
        value = source.node(path).value
        if "a mapping" in expected and (slip := _slip_in_text(value)):
            return diagnostic("CB205", source.place(*path), problem=slip)
        if example := form(model, path, source.node(path)):
            expected += f", as in {example}"
        found = describe(value) + _left_out(value, expected)
        return diagnostic("CB204", source.place(*path), expected=expected, found=found)
    fault = next(fault for fault in same if not fault.is_wrong_kind)
    return _special(fault, same, path, source, model)


def _row(
    path: tuple[Step, ...], same: list[_Fault], source: SourceMap, model: type[BaseModel]
) -> Diagnostic | None:
    """What is to be said of what should be a list, or a list less, where its values are there."""
    from cbdsl.yaml_text.row import meant_row  # only a fault needs it

    steps = path[:-1] if path and path[-1] == 0 else path
    is_inner = steps != path and isinstance(source.node(path).value, list)
    if not is_inner and all(fault.error["type"] != "tuple_type" for fault in same):
        return None
    node = source.node(steps if is_inner else path)
    row = meant_row(node, source)
    places = (form(model, path) or "").count("...")
    if row is None or (isinstance(node.value, str) and row.count(",") + 1 < places):
        return None
    found = "a list within a list" if is_inner else describe(node.value)
    return diagnostic("CB204", node.place, expected="a list", found=f"{found}; write {row}")


def _too_few(path: tuple[Step, ...], same: list[_Fault], source: SourceMap) -> Diagnostic:
    """What is to be said of a list that ends before its last value."""
    missing = [fault.error["loc"][-1] for fault in same if fault.error["type"] == "missing"]
    wanted = max(index for index in missing if isinstance(index, int)) + 1
    given = source.node(path)
    found = count(len(given.value) if isinstance(given.value, list) else 1, "value")
    parts = _PARTS.get(str(path[-1]))
    names = f": {parts}" if parts else ""
    problem = f"{found} where {wanted} are wanted{names}"
    return diagnostic("CB208", given.place, problem=problem)


def _special(
    fault: _Fault,
    same: list[_Fault],
    path: tuple[Step, ...],
    source: SourceMap,
    model: type[BaseModel],
) -> Diagnostic:
    error, name = fault.error, str(path[-1]) if path else ""
    context: dict[str, Any] = error.get("ctx", {})
    if error["type"] in _OF_KEYS and (slip := _slip_in_key(path, source)):
        return diagnostic("CB205", source.key(*path), problem=slip)
    match error["type"]:
        case "missing" if isinstance(error["loc"][-1], int):
            return _too_few(path, same, source)
        case "missing":
            # A missing key has no place of its own: its parent's key stands for it.
            place = source.key(*path[:-1])
            said = [(place, text) for text in _said_of(path, model)]
            return diagnostic("CB203", place, key=name, related=said)
        case "extra_forbidden":
            keys = sorted(Shape((model,)).located(error["loc"][:-1]).keys)
            return diagnostic("CB202", source.key(*path), names=keys, key=name)
        case "literal_error" | "union_tag_invalid":
            expected = str(context.get("expected") or context.get("expected_tags"))
            names = [text.strip(" '") for text in expected.replace(" or ", ",").split(",")]
            steps = path if error["type"] == "literal_error" else (*path, "shape")
            value = str(source.node(steps).value)
            return diagnostic("CB206", source.place(*steps), names=names, name=value)
        case "string_pattern_mismatch":
            at = source.key(*path) if "[key]" in error["loc"] else source.place(*path)
            return diagnostic("CB207", at, name=error["input"], hint=_named_instead(error["input"]))
        case "value_error":
            problem = _told(context["error"], error["input"])
            return diagnostic("CB205", source.place(*path), problem=problem)
    if error["type"] == "too_long" and (comma := decimal_comma(source.node(path))):
        return diagnostic("CB205", source.place(*path), problem=comma)
    problem = _PROBLEMS.get(error["type"], error["msg"]).format(**context)
    return diagnostic("CB208", source.place(*path), problem=problem)


def _told(error: ValueError, value: object) -> str:
    from cbdsl.types.quantity_slip import told  # only a fault needs it

    return told(value, error) if isinstance(error, QuantityError) else str(error)


def _left_out(value: object, expected: str) -> str:
    """The sign that made something else of what is expected, and has to be left out."""
    if "a mapping" in expected and isinstance(value, list) and all(map(_is_entry, value)):
        return "; leave out the '-' in front of each key" if value else ""
    is_key = isinstance(value, dict) and [child.value for child in value.values()] == [None]
    if isinstance(value, dict) and is_key and "text" in expected:
        return f"; leave out the ':' after '{next(iter(value))}'"
    return ""


def _is_entry(node: Node) -> bool:
    return isinstance(node.value, dict) and len(node.value) == 1


def _named_instead(text: str) -> str:
    """What to write for what is no name, such as a document's file."""
    core, *words = re.split(r"\s*(?:#|//)\s*", text, maxsplit=1)
    if words and re.match(NAME_PATTERN, core):
        return f"; a comment begins with a space and '#': write {core} # {words[0]}"
    file = PurePath(text.strip())
    if len(file.parts) > 1 or file.suffix in (".yaml", ".yml"):
        return f"; documents are named without folder and ending: write {file.stem}"
    name = re.sub(r"\W+", "_", text.strip(), flags=re.ASCII).strip("_")
    return f"; write {name}" if name != text and re.match(NAME_PATTERN, name) else ""


def _said_of(path: tuple[Step, ...], model: type[BaseModel]) -> set[str]:
    """What the documentation says of a key."""
    from cbdsl.documents.json_schema import docstrings  # only a fault needs it

    return {
        f"{path[-1]}: {text}"
        for section in Shape((model,)).at(path[:-1]).sections
        if (text := docstrings(section).get(str(path[-1])))
    }


def _slip_in_key(path: tuple[Step, ...], source: SourceMap) -> str | None:
    """What made a key out of what was never meant to be one."""
    mapping, key = source.node(path[:-1]).value, str(path[-1])
    if not isinstance(mapping, dict) or key not in mapping:
        return None
    is_alone = mapping[key].value is None
    tight, _, rest = key.partition(":")
    if rest and (is_alone or rest[0] in "{["):
        return f"a space is missing after the ':' of '{tight}'"
    name, sign, rest = key.partition("=")
    if sign and is_alone:
        return f"a ':' is missing after '{name.strip()}'; write '{name.strip()}: {rest.strip()}'"
    first, _, rest = key.partition(" ")
    if rest and (is_alone or rest[0] in "{["):
        return f"a ':' is missing after '{first}'"
    return None


def _slip_in_text(value: object) -> str | None:
    """What made a text out of a key and its value."""
    match = _KEY_AND_VALUE.match(value) if isinstance(value, str) else None
    if match is None:
        return None
    missing = "a space is missing after the ':' of" if match[2] else "a ':' is missing after"
    return f"{missing} '{match[1]}'"


def describe(value: object) -> str:
    """What a value is, as messages say it."""
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list):
        return "a list"
    if isinstance(value, bool):
        return f"'{value}'".lower()
    return "nothing" if value is None else f"'{value}'"
