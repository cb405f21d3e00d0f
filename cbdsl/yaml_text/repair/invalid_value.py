"""One of pydantic's errors, and its diagnostic."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from pathlib import PurePath
from typing import Any, NamedTuple

from pydantic import BaseModel
from pydantic_core import ErrorDetails

from cbdsl.diagnostics.counting import count
from cbdsl.diagnostics.diagnostic import Diagnostic, Place
from cbdsl.diagnostics.wording import diagnose
from cbdsl.documents.document import NAME_PATTERN
from cbdsl.types.quantity_problem import quantities_in, quantity_problem
from cbdsl.types.unit import QuantityError
from cbdsl.yaml_text.comma import decimal_comma
from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.repair.schema_shape import SchemaShape
from cbdsl.yaml_text.repair.sketch import form
from cbdsl.yaml_text.source_map import SourceMap, Step

_BRACKETS = re.compile(r"[\[({]?(?P<inner>.*?)[\])}]?", re.DOTALL)
_DASH = re.compile(r"(?:^|\s)-\s*(?=[^\W\d])")


def suggested_row(node: Node, source: SourceMap) -> str | None:
    """Return the list, in brackets, that a mapping, a text or a nested list probably represents."""
    value = node.value
    if isinstance(value, list):
        inner = value[0] if len(value) == 1 else None
        is_row = inner is not None and isinstance(inner.value, list) and _is_flat(inner)
        return source.written(inner) if inner is not None and is_row else None
    if isinstance(value, dict):
        return _of_mapping(node, value, source) if _is_flat(node) else None
    return f"[{', '.join(_of_text(str(value)))}]" if value is not None else None


def _is_flat(node: Node) -> bool:
    return not any(isinstance(child.value, (dict, list)) for child in node.children())


def _of_mapping(node: Node, value: dict[str, Node], source: SourceMap) -> str:
    """Return its values, or its keys if these have no values, as in ``{left_arm, right_arm}``."""
    if all(child.value is None for child in value.values()):
        return f"[{', '.join(value)}]"
    return f"[{', '.join(source.written(child) for child in node.children())}]"


def _of_text(text: str) -> list[str]:
    match = _BRACKETS.fullmatch(text.strip())
    inner = match["inner"].strip() if match else text
    # A quantity may contain spaces, as "3 cm 4 cm", so quantities precede words.
    if parts := quantities_in(inner):
        return parts
    if "," in inner:
        return [part.strip() for part in inner.split(",") if part.strip()]
    if _DASH.match(inner):
        return [part.strip() for part in _DASH.split(inner) if part.strip()]
    return [inner] if re.search(r"[^\w\s$]", inner) else inner.split()


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
    "greater_than": "{given} given, more than {gt:g} required",
    "greater_than_equal": "{given} given, at least {ge:g} required",
    "less_than": "{given} given, less than {lt:g} required",
    "less_than_equal": "{given} given, at most {le:g} allowed",
    "too_short": "{actual_length} given, at least {min_length} required",
    "too_long": "{actual_length} given, at most {max_length} allowed",
}
#: Names of the components of fixed-length lists.
_PARTS = {
    "offset": "x, y, z",
    "position": "x, y, z",
    "size": "x, y, z",
    "color": "red, green, blue",
}
_MANY = (dict, list)
_OF_KEYS = ("extra_forbidden", "string_pattern_mismatch")


class InvalidValue(NamedTuple):
    """Validation error of pydantic at its path in the text."""

    path: tuple[Step, ...]
    error: ErrorDetails

    @property
    def is_wrong_kind(self) -> bool:
        """True if the value has the wrong type."""
        return self.error["type"] in (*_EXPECTED, "not_named")

    @property
    def expected(self) -> str:
        """Name of the expected type of value."""
        kind, context = self.error["type"], self.error.get("ctx", {})
        return str(context["expected"]) if kind == "not_named" else _EXPECTED[kind]

    @property
    def is_of_parts(self) -> bool:
        """True if a more specific fault inside the value may cause this one."""
        is_whole = self.error["type"] == "value_error" and isinstance(self.error["input"], _MANY)
        return self.is_wrong_kind or is_whole or self.error["type"] == "too_short"


def diagnose_value(
    path: tuple[Step, ...], same: list[InvalidValue], source: SourceMap, model: type[BaseModel]
) -> Diagnostic:
    """Return the diagnostic of the faults of one value.

    Args:
        path: Path of the value.
        same: Faults of the value; several if it fails several members of a union.
        source: Source map of the document.
        model: Model of the kind of document.
    """
    if row := _row(path, same, source, model):
        return row
    if all(fault.is_wrong_kind for fault in same):
        expected = " or ".join(dict.fromkeys(fault.expected for fault in same))
        value = source.node(path).value
        example = form(model, path, source.node(path)) or ""
        keys = re.findall(r"\w+(?=:)", example)
        if "a mapping" in expected and (problem := text_problem(value, keys)):
            return diagnose("CB205", source.place(*path), problem=problem)
        if example:
            expected += f", as in {example}"
        given = describe(value) + left_out(value, expected)
        return diagnose("CB204", source.place(*path), expected=expected, found=given)
    return _special(path, same, source, model)


def _row(
    path: tuple[Step, ...], same: list[InvalidValue], source: SourceMap, model: type[BaseModel]
) -> Diagnostic | None:
    """Return the diagnostic of a value with the items of a list in a wrong form, or ``None``."""
    steps = path[:-1] if path and path[-1] == 0 else path
    is_inner = steps != path and isinstance(source.node(path).value, list)
    if not is_inner and all(fault.error["type"] != "tuple_type" for fault in same):
        return None
    node = source.node(steps if is_inner else path)
    row = suggested_row(node, source)
    places = (form(model, path) or "").count("...")
    if row is None or (isinstance(node.value, str) and row.count(",") + 1 < places):
        return None
    given = "a list within a list" if is_inner else describe(node.value)
    return diagnose("CB204", node.place, expected="a list", found=f"{given}; write {row}")


def not_allowed(place: Place, names: Sequence[str], value: object) -> Diagnostic:
    """Return the diagnostic of a value that is not among the allowed names."""
    if isinstance(value, str) and value in names and is_unquoted(value):
        given = f"'{value}' in quotes; leave out the quotes"
        return diagnose("CB204", place, names=names, given="", expected="a number", found=given)
    if isinstance(value, str):
        return diagnose("CB206", place, names=names, name=value)
    expected = "one of the allowed words"
    return diagnose("CB204", place, names=names, given="", expected=expected, found=describe(value))


def _too_few(path: tuple[Step, ...], same: list[InvalidValue], source: SourceMap) -> Diagnostic:
    """Return the diagnostic of a list with too few values."""
    missing = [fault.error["loc"][-1] for fault in same if fault.error["type"] == "missing"]
    wanted = max(index for index in missing if isinstance(index, int)) + 1
    given = source.node(path)
    given_values = count(len(given.value) if isinstance(given.value, list) else 1, "value")
    parts = _PARTS.get(str(path[-1]))
    names = f": {parts}" if parts else ""
    problem = f"{given_values} given, {wanted} required{names}"
    return diagnose("CB208", given.place, problem=problem)


def _special(
    path: tuple[Step, ...], same: list[InvalidValue], source: SourceMap, model: type[BaseModel]
) -> Diagnostic:
    """Return the diagnostic of a value of the right type that is invalid."""
    error = next(fault.error for fault in same if not fault.is_wrong_kind)
    name = str(path[-1]) if path else ""
    context: dict[str, Any] = error.get("ctx", {})
    if error["type"] in _OF_KEYS and (problem := key_problem(path, source)):
        return diagnose("CB205", source.key(*path), problem=problem)
    match error["type"]:
        case "missing" if isinstance(error["loc"][-1], int):
            return _too_few(path, same, source)
        case "missing":
            # A missing key has no place of its own: the place of its parent's key is reported.
            place = source.key(*path[:-1])
            related = [(place, text) for text in _documentation(path, model)]
            return diagnose("CB203", place, key=name, related=related)
        case "extra_forbidden":
            shape = SchemaShape((model,)).located(error["loc"][:-1])
            if new := shape.renamed.get(name):
                return diagnose("CB211", source.key(*path), old=name, new=new)
            advice = shape.moved.get(name)
            keys, hint = ([], f"; {advice}") if advice else (sorted(shape.keys), "")
            return diagnose("CB202", source.key(*path), names=keys, key=name, hint=hint)
        case "literal_error" | "union_tag_invalid":
            # pydantic lists the allowed words as one text, such as "'a', 'b' or 'c'".
            expected = str(context.get("expected") or context.get("expected_tags"))
            names = [text.strip(" '") for text in expected.replace(" or ", ",").split(",")]
            steps = path if error["type"] == "literal_error" else (*path, "shape")
            return not_allowed(source.place(*steps), names, source.node(steps).value)
        case "string_pattern_mismatch":
            at = source.key(*path) if "[key]" in error["loc"] else source.place(*path)
            return diagnose("CB207", at, name=error["input"], hint=named_instead(error["input"]))
        case "value_error":
            problem = _problem(context["error"], error["input"])
            return diagnose("CB205", source.place(*path), problem=problem)
    if error["type"] == "too_long" and (comma := decimal_comma(source.node(path))):
        return diagnose("CB205", source.place(*path), problem=comma)
    given = describe(source.node(path).value)
    problem = _PROBLEMS.get(error["type"], error["msg"]).format(given=given, **context)
    return diagnose("CB208", source.place(*path), problem=problem)


def _problem(error: ValueError, value: object) -> str:
    return quantity_problem(value, error) if isinstance(error, QuantityError) else str(error)


def _documentation(path: tuple[Step, ...], model: type[BaseModel]) -> set[str]:
    """Return the docstrings of a key."""
    from cbdsl.documents.json_schema import docstrings  # only a missing key needs it

    return {
        f"{path[-1]}: {text}"
        for section in SchemaShape((model,)).at(path[:-1]).sections
        if (text := docstrings(section).get(str(path[-1])))
    }


def describe(value: object) -> str:
    """Describe a value for a message."""
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list):
        return "a list"
    if isinstance(value, bool):
        return f"'{value}'".lower()
    return "nothing" if value is None else f"'{value}'"


_KEY_AND_PLAIN_VALUE = re.compile(r"(\w+)(:?)(?: +|(?<=:))\S")
_KEY_AND_VALUE = re.compile(r"(\w+)(:?) *(?:&\w+ +)?[-{\[*]")


def key_problem(path: tuple[Step, ...], source: SourceMap) -> str | None:
    """Return the mistake by which other text became a key, or ``None``."""
    mapping, key = source.node(path[:-1]).value, str(path[-1])
    if not isinstance(mapping, dict) or key not in mapping:
        return None
    is_alone = mapping[key].value is None
    # Such a key is pan:head without a value, or models:{pan from models:{pan: head}.
    tight, _, rest = key.partition(":")
    if rest and (is_alone or rest[0] in "{["):
        return f"a space is missing after the ':' of '{tight}'"
    name, sign, rest = key.partition("=")
    if sign and is_alone:
        return f"a ':' is missing after '{name.strip()}'; write '{name.strip()}: {rest.strip()}'"
    # Such a key is "arm right" without a value, or "track {gain" from track {gain: 3}.
    first, _, rest = key.partition(" ")
    if rest and (is_alone or rest[0] in "{["):
        return f"a ':' is missing after '{first}'"
    return None


def text_problem(value: object, keys: Collection[str] = ()) -> str | None:
    """Return the mistake by which a key and its value became a text, or ``None``.

    Args:
        value: Value in the place of a mapping.
        keys: Known keys of that mapping, which a plain value may follow.
    """
    if not isinstance(value, str):
        return None
    match = _KEY_AND_VALUE.match(value)
    plain = _KEY_AND_PLAIN_VALUE.match(value)
    if match is None and plain is not None and plain[1] in keys:
        match = plain
    if match is None:
        return None
    missing = "a space is missing after the ':' of" if match[2] else "a ':' is missing after"
    return f"{missing} '{match[1]}'"


def left_out(value: object, expected: str) -> str:
    """Return the advice to omit or add a sign that gives a value another type than expected."""
    if "a mapping" in expected and isinstance(value, list) and all(map(_is_entry, value)):
        return "; leave out the '-' in front of each key" if value else ""
    is_key = isinstance(value, dict) and [child.value for child in value.values()] == [None]
    if isinstance(value, dict) and is_key and "text" in expected:
        return f"; leave out the ':' after '{next(iter(value))}'"
    if isinstance(value, bool | int | float) and "text" in expected:
        word = str(value).lower() if isinstance(value, bool) else value
        return f'; a text has quotes: "{word}"'
    is_plain = any(word in expected for word in ("number", "integer", "true or false"))
    if is_plain and isinstance(value, str) and is_unquoted(value):
        return "; leave out the quotes"
    return ""


def is_unquoted(text: str) -> bool:
    """Return whether a text would be a number or a truth value without its quotes."""
    return bool(re.fullmatch(r"true|false|[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", text))


def _is_entry(node: Node) -> bool:
    return isinstance(node.value, dict) and len(node.value) == 1


def named_instead(text: str) -> str:
    """Return the remedy for a text that is not a valid name, such as a document's file."""
    core, *words = re.split(r"\s*(?:#|//)\s*", text, maxsplit=1)
    if words and re.match(NAME_PATTERN, core):
        return f"; a comment begins with a space and '#': write {core} # {words[0]}"
    file = PurePath(text.strip())
    if len(file.parts) > 1 or file.suffix in (".yaml", ".yml"):
        return f"; documents are named without folder and ending: write {file.stem}"
    name = re.sub(r"\W+", "_", text.strip(), flags=re.ASCII).strip("_")
    return f"; write {name}" if name != text and re.match(NAME_PATTERN, name) else ""
