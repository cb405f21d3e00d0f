"""Quantities in terms of a robot: values of its document, and measures of its bench."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from cbdsl.types.unit import QuantityError, parse_quantity

#: Robot of a stage that is for any.
ANY_ROBOT = "any"

_TERM = r"(?:bench\.[xyz]|(?:\d+\.?\d*|\.\d+)\s*[A-Za-z]+)"
#: Regular expression of a text that only a robot makes a quantity: a value such as
#: ``$arm.gap``, or a sum of measures of its bench such as ``bench.x - 0.2 reach``.
RELATIVE = (
    r"^\s*(?:\$[A-Za-z]\w*(?:\.[A-Za-z]\w*)?"
    rf"|(?=.*(?:bench\.|reach|span))[+-]?\s*{_TERM}(?:\s*[+-]\s*{_TERM})*)\s*$"
)
_PART = re.compile(r"\$([A-Za-z]\w*)(\.[A-Za-z]\w*)?")
_SUM = re.compile(rf"([+-]?)\s*({_TERM})")


class Unmeasured(float):
    """Quantity in terms of a robot that is not there yet: not a number.

    Attributes:
        text: Text of the document.
    """

    text: str

    def __new__(cls, text: str) -> Unmeasured:
        """Return the quantity of a text."""
        quantity = super().__new__(cls, math.nan)
        quantity.text = text
        return quantity

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Unmeasured) and self.text == other.text

    def __hash__(self) -> int:
        return hash(self.text)


def is_relative(value: object) -> bool:
    """Return whether a value is a text such as ``$arm.gap`` or ``0.4 reach``."""
    return isinstance(value, str) and re.match(RELATIVE, value) is not None


def replaced(value: Any, text: Callable[[str], Any]) -> Any:
    """Return a value of a document with a function applied to all its texts."""
    if isinstance(value, str):
        return text(value)
    if isinstance(value, dict):
        return {key: replaced(each, text) for key, each in value.items()}
    return [replaced(each, text) for each in value] if isinstance(value, (list, tuple)) else value


def with_parts(text: str, texts: Mapping[str, str]) -> str:
    """Return a text with ``$part`` and ``$part.name`` replaced.

    Args:
        text: Text with parts.
        texts: Text by ``part`` or ``part.name``; all others stay as they are.
    """

    def part(match: re.Match[str]) -> str:
        rest = match[2] or ""
        whole = texts.get(f"{match[1]}{rest}")
        if whole is None and match[1] in texts:
            whole = f"{texts[match[1]]}{rest}"
        return match[0] if whole is None else whole

    return _PART.sub(part, text)


def with_measures(text: str, measures: Mapping[str, float]) -> str | float:
    """Return the length of a sum of measures, m; any other text as it is.

    Args:
        text: Text such as ``bench.x - 0.2 reach``.
        measures: Lengths by name, m.

    Raises:
        KeyError: A measure is not known.
        QuantityError: A term has no unit of length.
    """
    if not measures or text.lstrip().startswith("$") or not is_relative(text):
        return text
    total = 0.0
    for sign, term in _SUM.findall(text):
        total += (-1.0 if sign == "-" else 1.0) * _length(term, measures)
    return total


def _length(term: str, measures: Mapping[str, float]) -> float:
    if term.startswith("bench."):
        return measures[term]
    name = term.lstrip("0123456789. ")
    if name in ("reach", "span"):
        return float(term[: -len(name)]) * measures[name]
    length, unit = parse_quantity(term)
    if unit is None or unit.dimension != "length":
        raise QuantityError(f"'{term}' is no length")
    return length


def named(value: Any) -> Iterator[str]:
    """Yield the names ``part.name`` in all texts of a value of a document."""
    if isinstance(value, str):
        yield from (f"{match[1]}{match[2]}" for match in _PART.finditer(value) if match[2])
    elif isinstance(value, (dict, list, tuple)):
        for each in value.values() if isinstance(value, dict) else value:
            yield from named(each)
