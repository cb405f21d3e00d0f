"""First causes of made episodes: each kind by its evidence, and only by it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_history import TICKS, course, flags, made, predicates, pressed, transition

import cbdsl_why as package
from cbdsl.reporting.recorded import read_recording
from cbdsl.runtime.causes import BLOCKED, OPTIMUM, OUT_OF_REACH, SINGULAR, RestCause
from cbdsl.runtime.recording import HOLDERS, SIGHT
from cbdsl_why.diagnosis import FAMILIES, diagnose
from cbdsl_why.history import FailureCause, History
from tests.reporting.conftest import Record
from tests.runtime.synthetic import World

END = slice(60, TICKS)
_GONE = np.tile([0.8, 0.1, 0.0], (TICKS, 1))
_GONE[60:] = np.nan
_NEVER = np.full((TICKS, 3), np.nan)
_TIMED_OUT = [transition("0XX", "reach", "0XX", 2.0, 110)]
_SHORT = {"transitions": _TIMED_OUT, "level_share": course(0.1, 0, END, 1.0)}
_NEARER = np.linspace(0.3, 0.1, TICKS)[:, None] * np.ones(3)
_LOST = predicates(("0XX", 60), ("-XX", 60))


def sight(code: str, ticks: slice = END, usual: str = "seen") -> np.ndarray:
    """Return the sight of the ball by tick."""
    array = np.full((TICKS, 1), SIGHT.index(usual))
    array[ticks] = SIGHT.index(code)
    return array


@pytest.mark.parametrize(
    ("kind", "tick", "changes"),
    [
        ("never_seen", 0, {"predicates": ["-XX"] * TICKS, "signal_stereo__red": _NEVER,
                           "sight": sight("unseen", slice(None))}),
        ("occluded", 60, {"predicates": ["-XX"] * TICKS, "signal_stereo__red": _NEVER,
                          "sight": sight("partly", usual="unseen")}),
        ("ambiguous", 60, {"predicates": ["-XX"] * TICKS, "signal_stereo__red": _NEVER,
                           "sight": sight("ambiguous", usual="unseen")}),
        ("lost", 60, {"predicates": _LOST, "signal_stereo__red": _GONE, "sight": sight("unseen")}),
        ("occluded", 40, {"predicates": _LOST, "signal_stereo__red": _GONE,
                          "sight": sight("hidden", slice(40, TICKS))}),
        ("lost", 50, {"predicates": _LOST, "signal_stereo__red": _GONE,
                      "sight": np.where(np.arange(TICKS)[:, None] < 60,
                                        sight("missing", slice(50, 60)), sight("unseen"))}),
        ("ambiguous", 60, {"predicates": _LOST, "signal_stereo__red": _GONE,
                           "sight": sight("unseen", usual="several")}),
        ("wrong_order", 0, {"predicates": ["X-X"] * TICKS,
                            "level_priority": -np.ones((TICKS, 3), dtype=int),
                            "flags": flags("seeking", 1, slice(0, 60))
                            | flags("exhausted", 1, END)}),
        ("out_of_reach", 0, {"transitions": _TIMED_OUT,
                             "signal_stereo__red": np.tile([1.2, 0.0, 0.0], (TICKS, 1))}),
        ("held", 0, {"transitions": _TIMED_OUT, "level_share": course(0.1, 0, END, 1.0),
                     "level_held_by": course(2, 0, END, -1).astype(int)}),
        ("limit", 0, {"transitions": _TIMED_OUT, "level_share": course(0.1, 0, END, 1.0),
                      "level_held_by": course(3, 0, END, -1).astype(int)}),
        ("limit", 0, {**_SHORT, "at_limits": np.ones((TICKS, 2), dtype=bool)}),
        ("stuck", 0, {**_SHORT, "level_singular_value": course(0.01, 0, END, 1.0)}),
        ("stuck", 0, {**_SHORT, "level_held_by":
                      course(3 + HOLDERS.index(OPTIMUM), 0, END, -1).astype(int)}),
        ("time", 119, {"transitions": [transition("XXX", "reach", "0XX", 1.0, 60)],
                       "limits": {"pick": {"transitions": 1}}}),
        ("time", 119, {"limits": {"pick": {"episode_time": 2.0}}, "errors": _NEARER}),
        ("guard", 0, {"transitions": _TIMED_OUT, "guard_held": np.ones((TICKS, 1), dtype=bool)}),
        ("slip", 60, {"predicates": predicates(("X0X", 30), ("X1X", 30), ("X-X", 60))}),
        ("slip", 118, {"predicates": predicates(("X1X", 118), ("X-X", 2))}),
        ("slip", 60, {"predicates": predicates(("X1X", 30), ("XXX", 1), ("X0X", 29), ("X-X", 60))}),
        ("wrong_object", 60, {"predicates": ["X0X"] * TICKS, "flags": flags("astray", 1, END),
                              **pressed(2.0, 0.02)}),
        ("no_action", 60, {"transitions": [transition("XXX", "reach", "1XX", 1.0, 60)],
                           "predicates": predicates(("0XX", 60), ("1XX", 60))}),
        ("cycle", 60, {"predicates": ["X0X"] * TICKS, "transitions": [
            transition("1X", "a", "X1", 0.5 * n + 0.25, 15) if n % 2 == 0
            else transition("X1", "b", "1X", 0.5 * n + 0.25, 15) for n in range(6)]}),
        ("not_followed", 60, {"references": np.where(np.arange(TICKS)[:, None] < 60, 0.0, 0.5)
                              * np.array([1.0, 0.0])}),
    ],
)  # fmt: skip
def test_diagnose_names_the_kind_and_the_tick(
    kind: str, tick: int, changes: dict[str, Any]
) -> None:
    diagnosis = diagnose(made(**changes))
    assert diagnosis.cause is not None
    assert (diagnosis.cause.kind, diagnosis.cause.tick) == (kind, tick)


def test_diagnose_of_a_level_that_no_joint_moves_names_no_limit() -> None:
    limits = {**_SHORT, "at_limits": np.ones((TICKS, 2), dtype=bool)}
    assert "limit" not in _all(made(**limits, level_rank=np.zeros((TICKS, 3), dtype=int)))


def test_diagnose_of_simultaneous_causes_names_the_contact_before_the_sight() -> None:
    facts = {"predicates": predicates(("01X", 60), ("--X", 60)), "signal_stereo__red": _GONE}
    missing = np.where(np.arange(TICKS)[:, None] < 60, sight("missing", slice(55, 60)), 0)
    diagnosis = diagnose(made(**facts, sight=missing))
    assert [each.kind for each in _causes(made(**facts, sight=missing))][:2] == ["slip", "lost"]
    assert diagnosis.others[0].tick == 55


def test_diagnose_ignores_an_object_that_was_seen_later() -> None:
    late = np.where(np.arange(TICKS)[:, None] < 30, np.nan, [0.8, 0.1, 0.0])
    unseen = sight("unseen", slice(0, 30))
    seen = predicates(("-XX", 30), ("0XX", 90))
    facts = {"predicates": seen, "signal_stereo__red": late, "sight": unseen}
    assert _all(made(**facts, transitions=[])) == []


def test_diagnose_of_a_slow_arm_far_from_its_target_names_time() -> None:
    """A limited error says nothing, but the motion of the arm does."""
    slow = np.linspace([0.0, 0.0], [0.02, 0.0], 120)
    limits = {"pick": {"episode_time": 2.0}}
    assert "time" in _all(made(limits=limits, positions=slow, references=slow))


def test_diagnose_of_an_episode_whose_members_stand_still_names_no_time() -> None:
    assert "time" not in _all(made(limits={"pick": {"episode_time": 2.0}}))


def test_diagnose_names_an_event_before_an_earlier_end() -> None:
    stated = {**transition("X1", "hold", "X1", 0.5, 30), "reason": "it is late"}
    slip = {"predicates": predicates(("X1X", 60), ("X-X", 60)), "transitions": [stated]}
    assert _all(made({"outcome": "failure"}, **slip)) == ["slip", "stated"]


def test_diagnose_of_a_halted_episode_names_its_error() -> None:
    halted = {"halted": True, "ending": "Failed after 2.0 s in state 0XX: no answer."}
    diagnosis = diagnose(made(halted))
    assert diagnosis.cause is not None
    assert diagnosis.cause.kind == "backend"
    assert "no answer" in diagnosis.cause.sentence


@pytest.mark.parametrize(
    ("first", "kind"),
    [([0.8, 0.1, 0.0], "translation"), ([1.0, 0.02, 0.0], "no_grasp")],
    ids=["beside", "between"],
)
def test_diagnose_of_a_miss_compares_the_fingers_with_the_object(
    first: list[float], kind: str
) -> None:
    closing = predicates(("0XX", 60), ("X-X", 60))
    acts = course(0, 0, slice(0, 60), -1)
    diagnosis = diagnose(
        made(
            predicates=closing,
            level_priority=acts.astype(int),
            flags=flags("seeking", 1, slice(60, 90)) | flags("exhausted", 1, slice(90, TICKS)),
            signal_stereo__red=np.tile(first, (TICKS, 1)),
        )
    )
    assert diagnosis.cause is not None
    assert diagnosis.cause.kind == kind


def test_diagnose_ignores_a_slip_that_was_made_good() -> None:
    regained = predicates(("X1X", 40), ("X-X", 40), ("X1X", 40))
    assert not [each for each in _all(made(predicates=regained)) if each == "slip"]


# The hand closes in the tick of a transition, whose recorded letters are those after it.
_CLOSED_AT = transition("X0", "grip", "X1", 0.5, 30)


def test_diagnose_of_a_slip_after_a_grasp_that_ended_an_action_names_the_slip() -> None:
    changes = {"predicates": predicates(("X0X", 60), ("X-X", 60)), "transitions": [_CLOSED_AT]}
    diagnosis = diagnose(made(**changes))
    assert diagnosis.cause is not None
    assert (diagnosis.cause.kind, diagnosis.cause.tick) == ("slip", 60)
    assert "slip" not in _all(made(**changes | {"transitions": []}))


@pytest.mark.parametrize(("force", "slips"), [("0.4", 1), ("4", 2)], ids=["leans", "holds"])
def test_diagnose_counts_no_loss_of_leaning_fingers_that_hold_later(force: str, slips: int) -> None:
    triple = {**made().summary["triples"]["hold"], "reference": f"{force} N along normals"}
    triples = {**made().summary["triples"], "hold": triple}
    lost = predicates(("X1X", 30), ("X-X", 30), ("X1X", 30), ("X-X", 30))
    (cause,) = [e for e in _causes(made(predicates=lost, triples=triples)) if e.kind == "slip"]
    assert cause.times == slips


def test_diagnose_of_a_heavy_object_that_leaning_fingers_lost_does_not_know() -> None:
    triple = {**made().summary["triples"]["hold"], "reference": "0.4 N along normals"}
    loads = np.zeros((TICKS, 2, 6))
    loads[:60, :, 1] = 0.6
    history = made(
        predicates=predicates(("X1X", 60), ("X-X", 60)),
        triples={**made().summary["triples"], "hold": triple},
        loads=loads,
    )
    assert diagnose(history).cause is None
    assert "it is heavy" in diagnose(history).doubts[0]


def test_diagnose_without_evidence_does_not_know_and_rules_out() -> None:
    diagnosis = diagnose(made(transitions=[], predicates=["XXX"] * TICKS))
    assert diagnosis.cause is None
    assert len(diagnosis.ruled_out) == len(FAMILIES)


def test_diagnose_of_a_success_has_no_cause() -> None:
    diagnosis = diagnose(made({"outcome": "success", "rewarded": True}))
    assert (diagnosis.failed, diagnosis.cause) == (False, None)


def test_diagnose_of_an_older_recording_names_the_missing_facts() -> None:
    history = made()
    kept = {k: v for k, v in history.recorded.arrays.items() if k not in ("flags", "sight")}
    older = History(type(history.recorded)(history.recorded.file, history.summary, kept))
    assert "older cb" in diagnose(older).missing


def test_finders_read_no_truth() -> None:
    assert package.__file__ is not None
    for file in Path(package.__file__).parent.glob("*.py"):
        assert '"scene"' not in file.read_text("utf-8"), file


def test_diagnose_of_a_recorded_search_names_the_unseen_colour(record: Record) -> None:
    history = History(read_recording(record("searchtrack", begin=lambda rng: World())))
    diagnosis = diagnose(history)
    assert diagnosis.cause is not None
    assert diagnosis.cause.kind == "never_seen"
    assert "sat_10" in diagnosis.cause.sentence


def _all(history: History) -> list[str]:
    return [each.kind for each in _causes(history)]


def _causes(history: History) -> list[FailureCause]:
    diagnosis = diagnose(history)
    first = [] if diagnosis.cause is None else [diagnosis.cause]
    return [*first, *diagnosis.others]


@pytest.mark.parametrize(
    ("cause", "kind"),
    [
        (RestCause(BLOCKED, joints=("elbow",), obstructions=("pad touches base",)), "not_followed"),
        (RestCause(BLOCKED, joints=("shoulder", "elbow")), "not_followed"),
        (RestCause(OUT_OF_REACH), "out_of_reach"),
        (RestCause(SINGULAR), "stuck"),
    ],
    ids=str,
)
def test_diagnosis_states_the_recorded_cause_in_full(cause: RestCause, kind: str) -> None:
    history = made({"causes": {"reach": str(cause)}}, transitions=_TIMED_OUT)
    first = diagnose(history).cause
    assert first is not None
    assert first.kind == kind and first.sentence.endswith(f": {cause}")
