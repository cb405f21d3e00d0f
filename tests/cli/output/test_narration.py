"""Transitions of programs with steps, in words."""

from __future__ import annotations

import pytest

from cbdsl.checking.program import check_program
from cbdsl.cli.output.narration import changes
from cbdsl.program.transition import Transition


@pytest.mark.parametrize(
    ("program", "action", "before", "after", "words"),
    [
        ("survey", "look", "XX0000000", "XX0101000", "look: wide true, slab true"),
        ("survey", "look", "XX0000000", "XX0-00000", "look: wide undefined"),
        ("survey", "searchtrack", "X0XXXXXXX", "X1XXXXXXX", "searchtrack: searchtrack succeeded"),
        ("survey", "open", "0XXXXXXXX", "1XXXXXXXX", "open: open at rest"),
        ("survey", "open", "0XXXXXXXX", "0XXXXXXXX", ""),
        ("reachtouch", "searchtrack", "0XX", "1XX", ""),
    ],
)
def test_changes_name_the_step_and_the_members_that_changed(
    program: str, action: str, before: str, after: str, words: str
) -> None:
    transition = Transition(program, 0, 0.0, before, action, after, 1, 0)
    assert changes(check_program(program), transition) == words
