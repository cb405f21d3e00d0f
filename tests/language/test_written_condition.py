"""Conditions as text: comparisons, operators and times."""

from __future__ import annotations

import pytest

from cbdsl.language.scanner import CompositionError
from cbdsl.language.written_condition import WrittenComparison, parse_condition


def shown(text: str) -> list[str]:
    """Return the parts of a condition in postfix order, each comparison as a sum above 0."""
    parts = []
    for part in parse_condition(text).parts:
        if isinstance(part, WrittenComparison):
            values = " ".join(f"{'+' if v.factor > 0 else '-'} {v.text}" for v in part.values)
            part = f"{values} {'>' if part.is_strict else '>='} 0"
        parts.append(part)
    return parts


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("stereo.$a.width > 3 cm", ["+ stereo.$a.width - 3 cm > 0"]),
        ("a.z <= -7 N", ["- 7 N - a.z >= 0"]),
        ("$hand.net.torque.x >= 0.3 N m", ["+ $hand.net.torque.x - 0.3 N m >= 0"]),
        ("a < b - c + 2", ["+ b - c + 2 - a > 0"]),
        (
            "a > 1 and not b > 2 or c > 3",
            ["+ a - 1 > 0", "+ b - 2 > 0", "not", "and", "+ c - 3 > 0", "or"],
        ),
        ("a > 1 and (b > 2 or c > 3)", ["+ a - 1 > 0", "+ b - 2 > 0", "+ c - 3 > 0", "or", "and"]),
        ("not not a > 1", ["+ a - 1 > 0"]),
        # Names may begin with words of the language.
        ("order > android", ["+ order - android > 0"]),
    ],
)
def test_parse_condition_returns_sums_and_operators_in_postfix_order(
    text: str, expected: list[str]
) -> None:
    assert shown(text) == expected


def test_parse_condition_returns_the_time_for_which_it_has_to_hold() -> None:
    assert parse_condition("a > 3 N for 0.3 s").hold.text == "0.3 s"
    assert parse_condition("a > 3 N for $time").hold.text == "$time"
    assert parse_condition("a > 3 N").hold is None


@pytest.mark.parametrize(
    ("text", "column", "message"),
    [
        ("a", 2, "expected '+', '-', '<' or '>' at the end"),
        ("a > ", 4, "expected a signal or a quantity at the end"),
        ("a > 1 b", 7, "expected 'and' or 'or' or 'for' or the end, found 'b'"),
        ("(a > 1", 7, "expected 'and' or 'or' or ')' at the end"),
        ("a > 1 for b", 11, "expected a duration such as '0.3 s', found 'b'"),
        ("a > 1 for 1 s and b > 2", 15, "expected the end, found 'and'"),
        (" and ".join(["a > 1"] * 13), 126, "expected at most 24 comparisons and operators"),
    ],
)
def test_parse_condition_of_invalid_text_reports_the_column(
    text: str, column: int, message: str
) -> None:
    with pytest.raises(CompositionError) as error:
        parse_condition(text)
    assert error.value.span.start == column
    assert str(error.value).startswith(message)
