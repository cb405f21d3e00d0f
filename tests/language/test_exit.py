"""Exits of steps: conditions of members' letters, and targets."""

from __future__ import annotations

import pytest

from cbdsl.language.exit import Target, parse_target, parse_when
from cbdsl.language.scanner import CompositionError


def letters(text: str, kind: str) -> list[list[tuple[str, str | None]]]:
    return [[(str(part.term), part.letters(kind)) for part in way] for way in parse_when(text)]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("lift at rest", [[("lift", "1s")]]),
        ("lift not  at  rest", [[("lift", "-0")]]),
        ("lift undefined and heavy moving", [[("lift", "-"), ("heavy", "0")]]),
        ("a moving or b at rest and c undefined", [[("a", "0")], [("b", "1s"), ("c", "-")]]),
        ("reach(sat_10, right_arm) at rest", [[("reach(sat_10, right_arm)", "1s")]]),
        # Words of the language remain names of controllers.
        ("and at rest and or moving", [[("and", "1s"), ("or", "0")]]),
        ("moving moving", [[("moving", "0")]]),
        ("otherwise", [[]]),
        ("otherwise at rest", [[("otherwise", "1s")]]),
        ("lift arrived or lift stuck", [[("lift", "1")], [("lift", "s")]]),
        ("lift not stuck", [[("lift", "-01")]]),
        ("lift succeeded", [[("lift", None)]]),
    ],
)
def test_parse_when_of_controllers_returns_their_letters(
    text: str, expected: list[list[tuple[str, str | None]]]
) -> None:
    assert letters(text, "controller") == expected


def test_parse_when_of_programs_and_conditions_has_their_own_words() -> None:
    assert letters("take not running", "program") == [[("take", "-1")]]
    assert letters("heavy and not wide", "condition") == [[("heavy", "1"), ("wide", "0")]]
    assert letters("heavy undefined", "condition") == [[("heavy", "-")]]


@pytest.mark.parametrize(
    ("text", "column", "message"),
    [
        ("lift resting", 6, "expected 'undefined' or 'moving' or 'at rest'"),
        ("lift at rest carry", 14, "expected 'and' or 'or' or the end, found 'carry'"),
        ("lift at rest and", 17, "expected a name at the end"),
        ("lift not", 9, "expected 'undefined' or 'moving' or 'at rest' or 'arrived'"),
        ("", 1, "expected a name at the end"),
    ],
)
def test_parse_when_of_invalid_text_reports_the_column(
    text: str, column: int, message: str
) -> None:
    with pytest.raises(CompositionError) as error:
        parse_when(text)
    assert error.value.span.start == column
    assert str(error.value).startswith(message)


def test_parse_target_of_ends_and_steps_keeps_the_reason() -> None:
    assert parse_target(" carry ") == Target("carry")
    assert parse_target("fail too heavy,\n for the hand") == Target(
        "fail", "too heavy, for the hand"
    )
    assert str(parse_target("fail too heavy")) == "fail too heavy"


@pytest.mark.parametrize(("text", "column"), [("", 1), ("1 carry", 1), ("carry it away", 7)])
def test_parse_target_of_invalid_text_reports_the_column(text: str, column: int) -> None:
    with pytest.raises(CompositionError) as error:
        parse_target(text)
    assert error.value.span.start == column
