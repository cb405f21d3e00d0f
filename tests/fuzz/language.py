"""The languages within documents: compositions, quantities, scalars, patterns, and their layout."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from itertools import product

from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.language.parser import parse
from cbdsl.language.scanner import CompositionError
from cbdsl.types.quantity_problem import problem_in, quantities_in, quantity_problem
from cbdsl.types.state import ANY, PREDICATES, STATE, closest_first, matches, overlap, split
from cbdsl.types.unit import UNITS, QuantityError, is_quantity, read_quantity
from cbdsl.yaml_text.reader import formatted_text
from cbdsl.yaml_text.scalar import ScalarError, resolve
from tests.fuzz.documents import ENTRY_POINTS as DOCUMENTS
from tests.fuzz.entry_point import EntryPoint

_DIMENSIONS = tuple({unit.dimension for unit in UNITS.values()})
_PATTERN = re.compile(STATE.replace("-", r"\*-"))
_MEMBERS = 5


def _composition(data: bytes) -> None:
    text = data.decode("utf-8", "replace")
    try:
        expression = parse(text)
    except CompositionError as error:
        assert str(error) and 0 <= error.span.start <= error.span.end
        return
    for term in expression.terms:
        assert term.name and 0 < term.span.start < term.span.end <= len(text) + 1


def _quantity(data: bytes) -> None:
    text = data.decode("utf-8", "replace")
    try:
        assert math.isfinite(read_quantity(text, _DIMENSIONS))
        assert is_quantity(text)
    except QuantityError as error:
        assert str(error) and quantity_problem(text, error)
    problem_in(text)
    assert all(map(is_quantity, quantities_in(text)))


def _scalar(data: bytes) -> None:
    try:
        resolve(data.decode("utf-8", "replace"))
    except ScalarError:
        return


def _pattern(data: bytes) -> None:
    """Check the algebra of two patterns of states against the sets of their states."""
    texts = data.decode("ascii", "replace").split("\n")[:2]
    length = min(map(len, texts))
    if len(texts) < 2 or not 0 < length <= _MEMBERS:
        return
    one, other = (text[:length] for text in texts)
    if not (_PATTERN.match(one) and _PATTERN.match(other)):
        return
    states = ["".join(letters) for letters in product(PREDICATES, repeat=length)]
    both = overlap(one, other)
    for state in states:
        in_both = matches(one, state) and matches(other, state)
        assert in_both == (both is not None and matches(both, state))
    parts = list(split(one, other))
    covered = [state for state in states if any(matches(part, state) for part in parts)]
    assert not parts or covered == [state for state in states if matches(one, state)]
    assert closest_first([one, other])[0].count(ANY) == min(one.count(ANY), other.count(ANY))


def _layout(data: bytes) -> None:
    """Check that ``cb fmt`` leaves its own output unchanged."""
    try:
        once = formatted_text(data.decode("utf-8", "replace"), "any.yaml")
    except DiagnosticsError:
        return
    assert formatted_text(once, "any.yaml") == once


def _compositions() -> Iterator[bytes]:
    for text in (
        *("posture", "posture ◁ reach(sat_10, right_arm)", "a <| b <| c", "touch($arm, $x.y)"),
        *("a ◁", "a(b", "a < b", "b ▷ a", "a(,)", "right_arm.position(1)", "◁ a", "a ◁\n  b"),
    ):
        yield text.encode()


def _quantities() -> Iterator[bytes]:
    yield from (f"1.5e-3 {unit}".encode() for unit in UNITS)
    for text in ("30 deg", "-0", "1,5 m", "[1 m, 2 m]", "5 metres", "2 ± 1 cm", "pi rad", "cm 2"):
        yield text.encode()


def _scalars() -> Iterator[bytes]:
    for text in (
        "1e999",
        "0755",
        "NO",
        "~",
        "1:30",
        ".inf",
        "0x1F",
        "1_000",
        "12345678901234567890",
    ):
        yield text.encode()


def _patterns() -> Iterator[bytes]:
    yield from (b"X01-*\n0**1*", b"X\n*", b"00\n11")


def _layouts() -> Iterator[bytes]:
    for own in DOCUMENTS.values():
        yield from own.seeds()


ENTRY_POINTS = {
    "composition": EntryPoint(_composition, _compositions),
    "quantity": EntryPoint(_quantity, _quantities),
    "scalar": EntryPoint(_scalar, _scalars),
    "pattern": EntryPoint(_pattern, _patterns),
    "layout": EntryPoint(_layout, _layouts),
}
