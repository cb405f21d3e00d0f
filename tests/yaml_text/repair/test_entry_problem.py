"""Texts that are almost entries, values or names, and valid ones."""

from __future__ import annotations

import re

import pytest

from cbdsl.documents.document import NAME_PATTERN
from cbdsl.yaml_text.repair.invalid_value import named_instead, text_problem


@pytest.mark.parametrize(
    "text", ["cup.yaml", "things/cup.yml", "cup#red", "cup//red", "a cup", "cup-1", "cup,"]
)
def test_invalid_name_is_reported_with_a_valid_one(text: str) -> None:
    proposed = re.search(r"write (\S+)", named_instead(text))
    assert proposed is not None
    assert re.match(NAME_PATTERN, proposed[1]) and proposed[1].startswith(("cup", "a_cup"))


@pytest.mark.parametrize("text", ["1", "", "7up", "cup"])
def test_invalid_name_without_letters_has_no_proposal(text: str) -> None:
    assert named_instead(text) == ""


@pytest.mark.parametrize("value", ["{link: palm}", "[a, b]", "*other"])
@pytest.mark.parametrize(("colon", "missing"), [(":", "a space"), ("", "a ':'"), (" ", "a ':'")])
def test_key_with_its_value_is_no_text(value: str, colon: str, missing: str) -> None:
    slip = text_problem(f"tip{colon}{value}")
    assert slip is not None and slip.startswith(missing) and slip.endswith("'tip'")


@pytest.mark.parametrize("value", ["palm", "left palm", 3.0, None, []])
def test_valid_values_have_no_problem(value: object) -> None:
    assert text_problem(value) is None


@pytest.mark.parametrize(("text", "is_mistake"), [
    ("rate:15 Hz", True), ("rate 15 Hz", True), ("rate", False), ("15 Hz", False),
    ("pace:15 Hz", False), ("pace 15 Hz", False),
])  # fmt: skip
def test_text_problem_finds_a_known_key_before_a_plain_value(text: str, is_mistake: bool) -> None:
    assert (text_problem(text, ["rate"]) is not None) == is_mistake
