"""Comparisons of signals and quantities, joined by words.

condition: either ["for" QUANTITY]
either: both ("or" both)*
both: part ("and" part)*
part: "not" part | "(" either ")" | sum ("<" | "<=" | ">" | ">=") sum
sum: ["-"] value (("+" | "-") value)*
value: SIGNAL | QUANTITY
"""

from __future__ import annotations

import re
from functools import lru_cache
from typing import NamedTuple

from cbdsl.language.expression import Span
from cbdsl.language.scanner import Scanner, span_of
from cbdsl.types.unit import UNITS

_UNIT = "|".join(sorted(map(re.escape, UNITS), key=len, reverse=True))
_QUANTITY = re.compile(rf"\d+(?:\.\d*)?(?:[eE][-+]?\d+)?(?:\s*(?:{_UNIT})(?![\w/^]))?")
_SIGNAL = re.compile(r"\$?[A-Za-z]\w*(?:[.=]\$?[\w?]+)*")
_PARAMETER = re.compile(r"\$[A-Za-z]\w*")
_SIGN = re.compile(r"<=|>=|<(?!\|)|>")
_PLUS, _MINUS, _OPEN, _CLOSE = (re.compile(sign) for sign in (r"\+", "-", r"\(", r"\)"))
_AND, _OR, _NOT, _FOR = (re.compile(rf"{word}\b") for word in ("and", "or", "not", "for"))

# Bound on the operators of one condition, far above readable ones.
_MOST = 24


class WrittenValue(NamedTuple):
    """Signal, parameter or quantity of a sum.

    Attributes:
        text: Text of it.
        factor: 1, or -1 if it is subtracted.
        span: Span of the text.
    """

    text: str
    factor: float
    span: Span


class WrittenComparison(NamedTuple):
    """Comparison of a sum with 0: all values of it on one side.

    Attributes:
        values: Values of the sum.
        is_strict: True if the sum has to be above 0; otherwise, 0 is enough.
        span: Span of the comparison.
    """

    values: tuple[WrittenValue, ...]
    is_strict: bool
    span: Span


class WrittenCondition(NamedTuple):
    """Condition in postfix order.

    Attributes:
        parts: Comparisons, and ``and``, ``or`` and ``not`` behind their operands.
        hold: Time for which it has to hold, as text, or ``None``.
    """

    parts: tuple[WrittenComparison | str, ...]
    hold: WrittenValue | None


@lru_cache(maxsize=1_000)
def parse_condition(text: str) -> WrittenCondition:
    """Read a condition such as ``$hand.net.force.z < -7 N for 0.3 s``.

    Raises:
        CompositionError: The text is no condition; the error has the place.
    """
    return _ConditionReader(text).condition()


class _ConditionReader:
    def __init__(self, text: str) -> None:
        self._scanner = Scanner(text)
        self._parts: list[WrittenComparison | str] = []

    def condition(self) -> WrittenCondition:
        scanner = self._scanner
        self._either()
        hold = None
        if scanner.take(_FOR):
            match = scanner.take(_PARAMETER) or scanner.expect(
                _QUANTITY, "a duration such as '0.3 s'"
            )
            hold = WrittenValue(match[0], 1.0, span_of(match))
        if not scanner.is_at_end:
            raise scanner.error(*(() if hold else ("'and'", "'or'", "'for'")), "the end")
        return WrittenCondition(tuple(self._parts), hold)

    def _add(self, part: WrittenComparison | str) -> None:
        if len(self._parts) == _MOST:
            raise self._scanner.error(f"at most {_MOST} comparisons and operators")
        self._parts.append(part)

    def _either(self) -> None:
        self._both()
        while self._scanner.take(_OR):
            self._both()
            self._add("or")

    def _both(self) -> None:
        self._part()
        while self._scanner.take(_AND):
            self._part()
            self._add("and")

    def _part(self) -> None:
        negations = 0
        while self._scanner.take(_NOT):
            negations += 1
        if self._scanner.take(_OPEN):
            self._either()
            self._scanner.expect(_CLOSE, "'and' or 'or' or ')'")
        else:
            self._add(self._comparison())
        if negations % 2:
            self._add("not")

    def _comparison(self) -> WrittenComparison:
        scanner = self._scanner
        start = scanner.next
        left = self._sum()
        sign = scanner.expect(_SIGN, "'+', '-', '<' or '>'")[0]
        right = self._sum()
        if sign[0] == "<":
            left, right = right, left
        values = (*left, *(value._replace(factor=-value.factor) for value in right))
        return WrittenComparison(values, len(sign) == 1, Span(start + 1, scanner.read + 1))

    def _sum(self) -> list[WrittenValue]:
        factor = -1.0 if self._scanner.take(_MINUS) else 1.0
        values = [self._value(factor)]
        while sign := self._scanner.take(_PLUS) or self._scanner.take(_MINUS):
            values.append(self._value(-1.0 if sign[0] == "-" else 1.0))
        return values

    def _value(self, factor: float) -> WrittenValue:
        scanner = self._scanner
        match = scanner.take(_QUANTITY) or scanner.expect(_SIGNAL, "a signal or a quantity")
        return WrittenValue(match[0].rstrip(), factor, span_of(match))
