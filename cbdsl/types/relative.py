"""Quantities in terms of a robot: values of its document, and measures of its bench."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
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
_SCALED = re.compile(r"(?:\d+\.?\d*|\.\d+)\s*(?:reach|span)\b")
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


def with_measures(text: str, measures: Callable[[], Mapping[str, float]]) -> str | float:
    """Return the length of a sum of measures, m; any other text with its scaled lengths in cm.

    Args:
        text: Text such as ``bench.x - 0.2 reach``, or ``here + [0 cm, 0 cm, 0.2 span]``.
        measures: Function that returns lengths by name, m; it is called for such texts alone.

    Raises:
        QuantityError: A measure is not known, or a term has no unit of length.
    """
    is_sum = is_relative(text) and not text.lstrip().startswith("$")
    if not (is_sum or _SCALED.search(text)) or not (known := measures()):
        return text
    if not is_sum:
        return _SCALED.sub(lambda match: length_text(_length(match[0], known)), text)
    terms = _SUM.findall(text)
    # Nanometres, so that a sum is the length that a document of one robot states.
    return round(sum((-1.0 if s == "-" else 1.0) * _length(term, known) for s, term in terms), 9)


def length_text(length: str | float) -> str:
    """Return the text of a length in metres, in centimetres; a text as it is."""
    return length if isinstance(length, str) else f"{100 * length:.9g} cm"


def _length(term: str, measures: Mapping[str, float]) -> float:
    if term.startswith("bench."):
        return measures[term]
    name = term.lstrip("0123456789. ")
    if name in ("reach", "span"):
        if name not in measures:
            raise QuantityError(f"it states no '{name}'; write {name}: WIDTH in 'values' of a hand")
        return float(term[: -len(name)]) * measures[name]
    length, unit = parse_quantity(term)
    if unit is None or unit.dimension != "length":
        raise QuantityError(f"'{term}' is no length")
    return length


def named(value: Any) -> list[str]:
    """Return the names ``part.name`` in all texts of a value of a document."""
    names: list[str] = []
    replaced(
        value, lambda text: names.extend(f"{m[1]}{m[2]}" for m in _PART.finditer(text) if m[2])
    )
    return names


def parts_in(value: Any) -> set[str]:
    """Return the names ``part`` of ``$part`` and ``$part.name`` in all texts of a value."""
    names: set[str] = set()
    replaced(value, lambda text: names.update(m[1] for m in _PART.finditer(text)))
    return names
