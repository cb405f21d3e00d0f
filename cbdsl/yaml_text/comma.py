"""Commas that split a value: decimal commas, lists without brackets, and calls without quotes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

from cbdsl.diagnostics.diagnostic import Place
from cbdsl.yaml_text.node import Node


# A comma ends a value within braces and brackets. From {gain: 1,5} YAML reads the value 1 and a
# second key "5" without a value; from [1,5] it reads two items. A quantity in the place of a key,
# followed by a comma or the closing brace, is thus a part of the value before it. Without a space
# after the comma, two halves of digits are certainly a decimal comma. With a space, a list may be
# intended as well, so that the value is ambiguous and is not repaired. Likewise, a comma ends
# {do: lift($arm} before the next argument of the call; any text up to its end belongs to it.
class Stray(NamedTuple):
    """Part of a value in the place of a key, because a comma ended the preceding part."""

    text: str
    place: Place


class Cut(NamedTuple):
    """Explanation of a value that a comma split.

    Attributes:
        problem: Diagnostic message, as a clause.
        whole: Text of the whole value, if it is unambiguous.
    """

    problem: str
    whole: str | None = None


def is_stray(text: str, rest: str, before: Iterable[str]) -> bool:
    """Return whether a quantity or an argument without a colon stands in the place of a key.

    Args:
        text: Text in the place of the key.
        rest: Remainder of the line after the text.
        before: Parts of the preceding value.
    """
    begins = text.lstrip("+-.")[:1]
    is_part = begins.isdigit() or _is_open(", ".join(before))
    return is_part and rest.lstrip()[:1] in (",", "}")


def _is_open(text: str) -> bool:
    """Return whether a text ends within the arguments of a call."""
    return text.count("(") > text.count(")")


def _call(text: str) -> str:
    return f"a ',' ends a value in brackets or braces; write the call in quotes: \"{text}\""


def _lacks_end(text: str) -> str:
    return f"the ')' of '{text}' is missing"


class SplitCall(NamedTuple):
    """Call in brackets that commas split.

    Attributes:
        text: Whole call.
        first: Item with its first part.
        rest: Number of items with the other parts.
    """

    text: str
    first: int
    rest: int

    @property
    def is_open(self) -> bool:
        """Whether it has no end in the list."""
        return _is_open(self.text)

    @property
    def problem(self) -> str:
        """Diagnostic message, as a clause."""
        return _lacks_end(self.text) if self.is_open else _call(self.text)


def split_calls(items: Sequence[Node]) -> Iterator[SplitCall]:
    """Yield the calls in a list that commas split; the last part may be a key."""
    first, parts = 0, list[str]()
    for place, item in enumerate(items):
        if not parts:
            first = place
        parts.append(next(iter(item.value), "") if isinstance(item.value, dict) else item.written)
        text = ", ".join(parts)
        if parts[-1] and _is_open(text) and not isinstance(item.value, dict):
            continue
        if len(parts) > 1 and parts[-1] and not _is_open(text):
            yield SplitCall(text, first, len(parts) - 1)
        parts.clear()
    if len(parts) > 1:
        yield SplitCall(", ".join(parts), first, len(parts) - 1)


def explain(key: str, value: Node, strays: Sequence[Stray]) -> Cut:
    """Explain which value a key's value and the stray quantities after it form."""
    parts = [_shown(value), *(stray.text for stray in strays)]
    text = ", ".join(parts)
    if "(" in value.written:
        return Cut(_lacks_end(text)) if _is_open(text) else Cut(_call(text), text)
    row = f"[{text}]"
    if len(parts) != 2 or not _are_halves(value, parts[1]):
        return Cut(f"a list is written in brackets; write '{key}: {row}'")
    whole = ".".join(parts)
    if _is_tight(value.place, strays[0].place):
        return Cut(_decimal(*parts), whole)
    return Cut(f"a ',' ends the value; write '{key}: {whole}', or '{key}: {row}' for a list")


def decimal_comma(node: Node) -> str | None:
    """Return the message about a decimal comma in a list, or ``None``."""
    items = node.value if isinstance(node.value, list) else []
    for one, other in pairwise(items):
        if _is_tight(one.place, other.place) and _are_halves(one, other.written):
            return _decimal(one.written, other.written)
    return None


def _shown(value: Node) -> str:
    """Return the text of a value, with the contents of collections abbreviated."""
    if isinstance(value.value, list):
        return "[...]"
    return "{...}" if isinstance(value.value, dict) else value.written or str(value.value)


def _are_halves(whole: Node, rest: str) -> bool:
    """Return whether two values may be the integer and fractional parts of one number."""
    # In Python, a boolean is an integer, too.
    return type(whole.value) is int and whole.written != "" and rest[:1].isdigit()


def _is_tight(one: Place, other: Place) -> bool:
    """Return whether only a comma separates two values, without a space."""
    return (one.line, one.end_column + 1) == (other.line, other.column)


def _decimal(whole: str, rest: str) -> str:
    return f"'{whole},{rest}' has a decimal comma; write '{whole}.{rest}'"
