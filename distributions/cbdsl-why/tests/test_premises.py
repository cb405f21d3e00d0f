"""Contradictions of made recordings: each is found, and suspends the causes behind it alone."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from made_history import TICKS, flags, made, predicates, pressed, transition

from cbdsl.runtime.recording import SIGHT
from cbdsl_why.diagnosis import diagnose
from cbdsl_why.premises import doubts

_TICK = np.arange(TICKS)
_MOVING = np.clip((_TICK - 60) / 60, 0.0, 1.0)[:, None] * np.array([1.0, 0.0])
_SHAKEN = 0.1 * np.array([1.0, 0.0]) * np.where(_TICK[:, None] % 2, 1.0, -1.0)
# It moves from the 40th tick on, 1 cm a tick, beside the hand at x = 1 m.
_DRIFTING = np.array([0.7, 0.4, 0.0]) + np.outer(np.clip(_TICK - 40, 0, 30), [0.0, 0.01, 0.0])
_UNEVEN = _TICK / 60 + 0.014 * (_TICK % 2)
_NEW = transition("1XX", "hold", "1XX", 11.0, 60)
_CLOSING = {
    "predicates": predicates(("0XX", 30), ("X-X", 90)),
    "level_priority": np.where(_TICK[:, None] < 30, [0, -1, 1], -1),
    "flags": flags("seeking", 1, slice(30, 90)) | flags("exhausted", 1, slice(90, TICKS)),
}
_FAR = np.tile([3.0, 0.0, 0.0], (TICKS, 1))
_BETWEEN = np.tile([1.0, 0.04, 0.0], (TICKS, 1))
# A drive that lagged before.
_YIELDS = np.where(_TICK[:, None] < 3, [0.0, 0.1], 0.0)
# The controller of the hand's forces acts from the 50th tick on.
_CLOSES = {"level_priority": np.where(_TICK[:, None] < 50, [0, -1, 1], [0, 2, 1])}
# A joint that runs ahead, an open hand that feels, and images that do not turn.
_RUNAWAY = {"positions": 2.0 * _MOVING, "references": _MOVING, "signal_stereo__red": _FAR}
_IDLE = {
    **pressed(1.0, 0.0, slice(0, TICKS)),
    "positions": _MOVING,
    "references": _MOVING,
    "signal_stereo__red": _FAR,
}
_UNMATCHED = np.where(_TICK < 30, SIGHT.index("seen"), SIGHT.index("unmatched"))[:, None]
_HEADING = {"type": "heading", "place": False, "channels": ["red"]}
_STALE = {
    "robot": {**made().summary["robot"], "cameras": {"left": {"link": "lower"}}},
    "signals": {**made().summary["signals"], "cyclopean.red": _HEADING},
    "signal_cyclopean__red": np.tile([0.2, 0.1], (TICKS, 1)),
    "positions": _MOVING,
    "references": _MOVING,
}
_HEAVY = {
    "predicates": predicates(("X0X", 30), ("X1X", 30), ("X-X", 60)),
    "loads": np.where(_TICK[:, None, None] < 60, [0.0, 3.0, 0.0, 0.0, 0.0, 0.0], 0.0)
    * np.ones((1, 2, 1)),
    "references": np.where(_TICK[:, None] < 60, [0.0, 0.02], 0.0),
}


@pytest.mark.parametrize(
    ("clause", "tick", "changes"),
    [
        ("early or late", 0, {"time": _UNEVEN}),
        ("encoder differ", 66, {"references": _MOVING, "positions": 0.5 * _MOVING}),
        ("read jumps", 0, {"positions": _SHAKEN, "signal_stereo__red": _FAR}),
        ("felt 0.2 N", 60, {**pressed(0.2, 0.1), **_CLOSES, "signal_stereo__red": _BETWEEN}),
        ("ahead of its reference", 63, _RUNAWAY),
        ("all its cells felt 1.0 N", 0, _IDLE),
        ("the images are old", 43, _STALE),
        ("behind its reference only", 60, {**pressed(5.0, 0.0), **_CLOSES, "references": _YIELDS,
                                           "signal_stereo__red": _BETWEEN}),
        ("bore 6.0 N", 60, _HEAVY),
        ("reversed", 0, {"references": 0.2 * _SHAKEN, "positions": 0.2 * _SHAKEN}),
        ("not at one position", 30, {"sight": _UNMATCHED, "signal_stereo__red": _FAR}),
        ("no hand was at it", 42, {"signal_stereo__red": _DRIFTING}),
    ],
)  # fmt: skip
def test_doubts_find_a_contradiction_with_its_tick(
    clause: str, tick: int, changes: dict[str, Any]
) -> None:
    found = [each for each in doubts(made(**changes)) if clause in each.clause]
    assert found
    assert abs(found[0].tick - tick) <= 6


def test_doubts_of_agreeing_facts_are_empty() -> None:
    assert doubts(made()) == []
    assert doubts(made(**pressed(2.0, 0.02))) == []
    followed = np.roll(_MOVING, 1, axis=0)
    assert doubts(made(references=_MOVING, positions=followed)) == []


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9])
def test_a_lag_below_the_allowed_share_is_no_doubt(share: float) -> None:
    lagging = np.maximum(_MOVING - share * 0.03, 0.0)
    assert doubts(made(references=_MOVING, positions=lagging)) == []


@pytest.mark.parametrize(
    "changes",
    [
        pressed(2.0, 0.02, slice(30, TICKS)),
        {"signal_stereo__red": _DRIFTING + np.array([0.3, -0.4, 0.0])},
        {"sight": np.full((TICKS, 1), SIGHT.index("several"))},
    ],
    ids=["touched", "at the hand", "one of several"],
)
def test_doubts_about_a_moving_object_need_an_untouched_one(changes: dict[str, Any]) -> None:
    assert doubts(made(**{"signal_stereo__red": _DRIFTING, **changes})) == []


@pytest.mark.parametrize(
    "changes",
    [
        {**_STALE, "signal_cyclopean__red": np.zeros((TICKS, 2))},
        {**_STALE, "signal_cyclopean__red": np.array([0.2, 0.1]) - _MOVING},
        {**_IDLE, "level_priority": np.tile([0, 2, 1], (TICKS, 1)),
         "references": _MOVING + np.array([0.0, 0.02])},
        {**pressed(5.0, 0.0), **_CLOSES},
        {"sight": _UNMATCHED},
        {"references": 0.2 * _SHAKEN, "positions": 0.2 * _SHAKEN,
         "loads": pressed(2.0, 0.0, slice(0, TICKS))["loads"]},
    ],
    ids=["followed", "turning", "closing", "stiff drive", "covered", "thrown back"],
)  # fmt: skip
def test_doubts_of_facts_that_contact_and_heads_explain_are_empty(changes: dict[str, Any]) -> None:
    assert doubts(made(**changes)) == []


@pytest.mark.parametrize("factor", [1.0, 0.15])
def test_doubts_about_a_load_need_a_load_that_weighs(factor: float) -> None:
    heavy = {**_HEAVY, "loads": factor * _HEAVY["loads"]}
    found = [each for each in doubts(made(**heavy)) if "of grip" in each.clause]
    assert bool(found) == (factor == 1.0)


@pytest.mark.parametrize(("lead", "found"), [(0.12, False), (0.02, True)])
def test_joint_that_an_object_throws_off_moves_at_most_by_the_largest_lead(
    lead: float, found: bool
) -> None:
    thrown = np.clip(_TICK - 60, 0, 6)[:, None] * np.array([0.01, 0.0])
    robot = {**made().summary["robot"], "lead": lead}
    assert bool(doubts(made(robot=robot, positions=thrown))) == found


def test_diagnose_of_an_object_that_moves_by_itself_does_not_know() -> None:
    gone = _DRIFTING.copy()
    gone[80:] = np.nan
    lost = {"predicates": predicates(("0XX", 80), ("-XX", 40)), "signal_stereo__red": gone}
    diagnosis = diagnose(made(**lost))
    assert diagnosis.cause is None
    assert diagnosis.others[0].kind == "lost"


def test_diagnose_behind_a_contradiction_does_not_know() -> None:
    lost = {"predicates": predicates(("X0X", 30), ("X1X", 30), ("X-X", 60))}
    assert getattr(diagnose(made(**lost)).cause, "kind", "") == "slip"
    diagnosis = diagnose(made(**lost, time=_UNEVEN))
    assert diagnosis.cause is None
    assert "early or late" in diagnosis.doubts[0]
    assert diagnosis.others[0].kind == "slip"


def test_diagnose_of_a_halt_behind_a_contradiction_knows() -> None:
    halted = {"halted": True, "ending": "Failed after 2.0 s: no answer."}
    assert getattr(diagnose(made(halted, time=_UNEVEN)).cause, "kind", "") == "backend"


def test_diagnose_before_a_contradiction_knows() -> None:
    never = {"predicates": ["-XX"] * TICKS, "signal_stereo__red": np.full((TICKS, 3), np.nan)}
    unseen = np.full((TICKS, 1), SIGHT.index("unseen"))
    diagnosis = diagnose(made(**never, sight=unseen, **pressed(0.2, 0.1)))
    assert getattr(diagnosis.cause, "kind", "") == "never_seen"
    assert diagnosis.doubts == ()


def test_diagnose_of_a_heavy_slip_states_load_and_grip() -> None:
    diagnosis = diagnose(made(**_HEAVY))
    assert diagnosis.cause is None
    assert "by 6.0 N of grip" in diagnosis.doubts[0]


def test_time_is_a_cause_only_while_a_member_comes_nearer() -> None:
    over = [transition("0XX", "reach", "0XX", 2.0, 119)]
    still = diagnose(made(transitions=over))
    assert still.cause is None
    assert (
        getattr(diagnose(made(transitions=[over[0], _NEW], time=_TICK / 10)).cause, "kind", "")
        == "time"
    )
    nearer = np.linspace(0.3, 0.1, TICKS)[:, None] * np.ones(3)
    assert getattr(diagnose(made(transitions=over, errors=nearer)).cause, "kind", "") == "time"
