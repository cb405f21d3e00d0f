"""Which transitions are decisions where a program is among the actions."""

from __future__ import annotations

from cbdsl.learning.decisions import Decisions
from tests.learning.conftest import Made


def test_program_is_one_decision_from_its_first_state(made: Made) -> None:
    decisions = Decisions({0: "find"})
    assert decisions.over(made("XX", "find", "0X")) is None
    assert decisions.over(made("0X", "find", "0X")) is None
    over = decisions.over(made("0X", "find", "1X"))
    assert over is not None and (over.state, over.action, over.next_state) == ("XX", "find", "1X")


def test_controller_transition_is_its_own_decision(made: Made) -> None:
    decisions, step = Decisions({0: "find"}), made("1X", "track", "X1")
    assert decisions.over(step) == step


def test_program_that_was_cut_off_does_not_reach_into_the_next_episode(made: Made) -> None:
    decisions = Decisions({0: "find"})
    assert decisions.over(made("X-", "find", "0-")) is None
    over = decisions.over(made("XX", "track", "X1"))
    assert over is not None and over.state == "XX"
