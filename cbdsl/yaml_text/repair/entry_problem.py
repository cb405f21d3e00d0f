"""Mistakes in entries, values and names, and their remedies."""

from __future__ import annotations

import re
from collections.abc import Collection
from pathlib import PurePath

from cbdsl.documents.document import NAME_PATTERN
from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.source_map import SourceMap, Step

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
