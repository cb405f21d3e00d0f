"""Rewards: members that newly quiesce, stated outcomes, and the predicate at the end."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from cbdsl.runtime.rewards import Conclusion, Rewards

TOUCH = SimpleNamespace(name="touch", part="touch")
REACH = SimpleNamespace(name="reach", part="reach")


def rules(*, success: tuple[str, ...] = (), earners: tuple[str, ...] = ("touch",)) -> Rewards:
    """Return the rules of a program with a controller ``touch`` and a subprogram ``reach``."""
    program: Any = SimpleNamespace(
        members=("touch", "reach"),
        success=success,
        failure=("-X", "*-"),
        reasons={"-X": "it is too wide"},
        primitives={"reach": SimpleNamespace(rewarded=True)},
        conditions={},
    )
    lead = SimpleNamespace(place=0, is_earned=bool(earners), earners=earners, stuck=True)
    levels: Any = SimpleNamespace(leads={"touch": [lead]})
    child: Any = SimpleNamespace(predicate="1", rewarded=True)
    return Rewards(program, levels, {"reach": child})


@pytest.mark.parametrize(
    ("action", "before", "after", "rewarding"),
    [
        (TOUCH, "0X", "1X", ("touch",)),
        (TOUCH, "1X", "1X", ()),
        (TOUCH, "1X", "0X", ()),
        (REACH, "X0", "X1", ("reach",)),
        (REACH, "X1", "X1", ()),
    ],
)
def test_rewarding_returns_members_that_newly_quiesce(
    action: Any, before: str, after: str, rewarding: tuple[str, ...]
) -> None:
    assert rules().rewarding(action, before, after) == rewarding


def test_rewarding_without_earned_signal_is_empty() -> None:
    assert rules(earners=()).rewarding(TOUCH, "0X", "1X") == ()  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("state", "conclusion"),
    [
        ("1X", Conclusion("success", "")),
        ("-X", Conclusion("failure", "it is too wide")),
        ("0-", Conclusion("failure", "")),
        ("0X", None),
    ],
)
def test_conclusion_of_a_state_has_its_outcome_and_reason(
    state: str, conclusion: Conclusion | None
) -> None:
    assert rules(success=("1*",)).conclusion(state) == conclusion


def test_conclusion_prefers_success_to_failure() -> None:
    assert rules(success=("-X",)).conclusion("-X") == Conclusion("success", "")


@pytest.mark.parametrize(
    ("success", "stuck", "state", "conclusion"),
    [
        (("1X",), ("touch",), "1X", Conclusion("failure", "")),
        (("1*",), ("reach",), "11", Conclusion("success", "")),
        (("11", "*1"), ("touch",), "11", Conclusion("success", "")),
        (("1*",), ("touch",), "1-", Conclusion("failure", "")),
        (("1*",), ("touch",), "0X", None),
        (("-X",), ("touch",), "-X", Conclusion("success", "")),
    ],
)
def test_conclusion_of_a_success_with_a_stuck_member_is_a_failure(
    success: tuple[str, ...], stuck: tuple[str, ...], state: str, conclusion: Conclusion | None
) -> None:
    assert rules(success=success).conclusion(state, stuck) == conclusion


def test_stuck_returns_the_members_of_the_running_action_beyond_their_tolerance() -> None:
    assert rules().stuck(TOUCH) == ("touch",) and rules().stuck(REACH) == ()


def test_final_predicate_with_a_stuck_member_is_no_success() -> None:
    given = rules(earners=())
    assert given.final("1X", changed=True, is_done=False) == "1"
    assert given.final("1X", ("touch",), changed=True, is_done=False) == "-"


@pytest.mark.parametrize(
    ("given", "state", "changed", "is_done", "predicate"),
    [
        ({"success": ("11",)}, "1X", True, True, "-"),
        ({}, "0X", False, True, "1"),
        ({}, "1X", True, False, "-"),
        ({"earners": ()}, "1X", True, False, "1"),
        ({"earners": ()}, "1X", False, False, "-"),
        ({"earners": ()}, "0X", True, False, "-"),
    ],
)
def test_final_predicate_follows_from_success_rewards_and_the_last_state(
    given: dict[str, Any], state: str, changed: bool, is_done: bool, predicate: str
) -> None:
    assert rules(**given).final(state, changed=changed, is_done=is_done) == predicate
