"""Causes of contact and of order from made episodes: each rule by its own evidence."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import made_history
import numpy as np
import pytest
from made_history import TICKS, course, flags, made, predicates, pressed, transition

from cbdsl_why.diagnosis import diagnose
from cbdsl_why.history import FailureCause, History
from cbdsl_why.premises import doubts

_TICK = np.arange(TICKS)
_TURNS = np.tile(np.eye(3), (TICKS, 1, 1))
_TRIPLE = {"potential": "spring", "reference": "", "base": "", "requires": ""}
_ORIENT = {**_TRIPLE, "feedback": "arm.orientation", "unit": "rad", "effector": "arm.orientation"}
_OF_TURN = {"type": "orientation", "place": False, "channels": []}
# The hand closes on nothing between the 60th and the 90th tick, with the object in its fingers.
_MISS: Mapping[str, Any] = {
    "predicates": predicates(("0XX", 60), ("X-X", 60)),
    "flags": flags("seeking", 1, slice(60, 90)) | flags("exhausted", 1, slice(90, TICKS)),
    "signal_stereo__red": np.tile([1.0, 0.02, 0.0], (TICKS, 1)),
    "signal_arm__orientation": _TURNS,
}


def _first(history: History) -> FailureCause:
    cause = diagnose(history).cause
    assert cause is not None
    return cause


def _kinds(history: History) -> list[str]:
    diagnosis = diagnose(history)
    first = [] if diagnosis.cause is None else [diagnosis.cause]
    return [each.kind for each in (*first, *diagnosis.others)]


def _triples(**changes: Mapping[str, Any]) -> dict[str, Any]:
    return {**made().summary["triples"], **changes}


def _signals(**changes: Mapping[str, Any]) -> dict[str, Any]:
    named = {name.replace("__", "."): facts for name, facts in changes.items()}
    return {**made().summary["signals"], **named}


def _acting(*priorities: int) -> np.ndarray:
    """Return the priorities of levels, the first of which acts in the first half only."""
    levels = np.tile(priorities, (TICKS, 1))
    levels[60:, 0] = -1
    return levels


@pytest.mark.parametrize(
    ("kind", "acts", "errors", "words"),
    [
        ("no_rotation", -1, 0.0, "posture had not turned the hand before"),
        ("no_rotation", 1, 0.5, "still 28.6 deg from its orientation"),
        ("rotation", 1, np.linspace(2.0, 0.4, TICKS), "from its orientation"),
    ],
    ids=["never turned", "not nearer", "not all the way"],
)
def test_miss_of_a_hand_short_of_its_orientation_is_its_rotation(
    kind: str, acts: int, errors: Any, words: str
) -> None:
    columns = np.full((TICKS, 3), 0.1)
    columns[:, 2] = errors
    facts = {"errors": columns, "level_priority": _acting(0, -1, acts)}
    signals = _signals(arm__orientation=_OF_TURN)
    cause = _first(made(**_MISS, **facts, triples=_triples(posture=_ORIENT), signals=signals))
    assert (cause.kind, cause.tick) == (kind, 60)
    assert words in cause.sentence


@pytest.mark.parametrize(("angle", "kind"), [(40, "rotation"), (5, "no_grasp")])
def test_miss_of_a_hand_across_its_object_is_a_rotation(angle: float, kind: str) -> None:
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    turned = np.tile([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]], (TICKS, 1, 1))
    triples = _triples(posture={**_ORIENT, "base": "stereo.red.turn"})
    signals = _signals(
        arm__orientation=_OF_TURN, stereo__red__turn={**_OF_TURN, "channels": ["red"]}
    )
    facts = {"signal_stereo__red__turn": turned, "errors": course(0.1, 0, slice(None), 0.0)}
    history = made(
        **_MISS, **facts, triples=triples, signals=signals, level_priority=_acting(0, -1, 1)
    )
    assert _first(history).kind == kind


@pytest.mark.parametrize(("tilt", "kind"), [(0.9, "rotation"), (0.1, "no_grasp")])
def test_miss_of_a_hand_tilted_against_another_controller_is_a_rotation(
    tilt: float, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(made_history, "CONTROLLERS", ("reach", "hold", "posture", "level"))
    triples = {
        **_triples(posture={**_ORIENT, "reference": f"{math.pi - tilt}, 0, 0"}),
        "level": {**_ORIENT, "reference": f"{math.pi}, 0, 0"},
    }
    history = made(
        **{
            **_MISS,
            "controllers": ["reach", "hold", "posture", "level"],
            "predicates": predicates(("0XXX", 60), ("X-XX", 60)),
            "flags": flags("seeking", 1, slice(60, 90)) | flags("exhausted", 1, slice(90, TICKS)),
            "errors": course(0.1, 0, slice(None), 0.0),
            "level_priority": _acting(0, -1, 1, -1),
        },
        triples=triples,
        signals=_signals(arm__orientation=_OF_TURN),
    )
    assert _first(history).kind == kind


def _touched(force: float, moved: float) -> History:
    loads = np.zeros((TICKS, 2, 6))
    loads[30:60, 0, 2] = force
    places = np.tile([0.9, 0.04, 0.0], (TICKS, 1))
    places[50:, 1] += moved
    history: History = made(loads=loads, signal_stereo__red=places)
    return history


def test_object_that_moves_after_a_touch_was_moved_by_it() -> None:
    cause = _first(_touched(0.5, 0.1))
    assert (cause.kind, cause.tick) == ("moved_by_touch", 30)
    assert "10.0 cm" in cause.sentence
    for history in (_touched(0.5, 0.01), _touched(0.0, 0.1)):
        assert "moved_by_touch" not in _kinds(history)


@pytest.mark.parametrize(("force", "count"), [(2.0, 1), (0.5, 0)], ids=["presses", "brushes"])
def test_fingertips_beside_the_object_are_on_another_one_only_if_they_press(
    force: float, count: int
) -> None:
    facts = pressed(force, 0.02)
    history = made(predicates=["X0X"] * TICKS, flags=flags("astray", 1, slice(60, TICKS)), **facts)
    assert _kinds(history).count("wrong_object") == count


def test_member_that_requires_a_contact_before_any_hand_closed_is_in_wrong_order() -> None:
    reach = {**made().summary["triples"]["reach"], "requires": "hold"}
    facts = {"predicates": ["-XX"] * TICKS, "triples": _triples(reach=reach)}
    cause = _first(made(**facts))
    assert (cause.kind, cause.tick) == ("wrong_order", 0)
    assert "reach requires hold" in cause.sentence
    tried = made(**facts, flags=flags("exhausted", 1, slice(0, 30)))
    assert "reach requires hold" not in str(diagnose(tried))


@pytest.mark.parametrize(
    ("confirmed", "kind"), [(False, "rotation"), (True, "slip")], ids=["against", "confirmed"]
)
def test_slip_of_an_object_that_a_turned_hand_had_grasped_is_a_rotation(
    confirmed: bool, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(made_history, "CONTROLLERS", ("reach", "hold", "posture", "level", "face"))
    down = {**_ORIENT, "reference": f"{math.pi}, 0, 0"}
    tilted = {**_ORIENT, "reference": f"{math.pi - 0.9}, 0, 0"}
    triples = _triples(posture=tilted, level=down, face=tilted if confirmed else down)
    history = made(
        controllers=["reach", "hold", "posture", "level", "face"],
        predicates=predicates(("X0XXX", 40), ("X1XXX", 20), ("X-XXX", 60)),
        errors=course(0.1, 0, slice(None), 0.0),
        level_priority=np.tile([-1, 0, 1, -1, -1], (TICKS, 1)),
        triples=triples,
        signals=_signals(arm__orientation=_OF_TURN),
        signal_arm__orientation=_TURNS,
    )
    assert _first(history).kind == kind


def test_hand_that_has_the_tilt_of_an_orientation_needs_no_turn() -> None:
    down = {**_ORIENT, "reference": f"{math.pi}, 0, 0"}
    levels = _acting(0, -1, -1)
    for turn, kind in (([1.0, -1.0, -1.0], "no_grasp"), ([1.0, 1.0, 1.0], "no_rotation")):
        facts = {**_MISS, "signal_arm__orientation": np.tile(np.diag(turn), (TICKS, 1, 1))}
        signals = _signals(arm__orientation=_OF_TURN)
        history = made(
            **facts, triples=_triples(posture=down), signals=signals, level_priority=levels
        )
        assert _first(history).kind == kind


@pytest.mark.parametrize(("acts", "slips"), [(1, 0), (-1, 1)], ids=["opens", "stays"])
def test_contact_that_ends_is_a_slip_unless_a_member_opens_the_hand(acts: int, slips: int) -> None:
    opened = {**_TRIPLE, "feedback": "hand", "unit": "rad", "effector": "hand"}
    history = made(
        predicates=predicates(("X1X", 60), ("X-X", 60)),
        triples=_triples(posture=opened),
        leads={"reach": "reach", "hold": "hold", "posture": "posture"},
        level_priority=np.tile([-1, 0, acts], (TICKS, 1)),
    )
    assert _kinds(history).count("slip") == slips


def test_program_that_states_a_failure_is_the_cause_with_its_reason() -> None:
    stated = {**transition("0XX", "reach", "-XX", 1.0, 60), "reason": "the place is too far"}
    cause = _first(made({"outcome": "failure"}, transitions=[stated]))
    assert (cause.kind, cause.tick) == ("stated", 60)
    assert cause.sentence == "pick states in -XX: the place is too far"


def test_used_program_without_an_action_for_its_state_is_the_cause() -> None:
    inner = {**transition("0", "go", "1", 1.0, 60), "depth": 1, "program": "sub", "use": "reach"}
    outer = transition("0X", "reach", "-X", 1.0, 60)
    cause = _first(made({"outcome": "failure"}, transitions=[inner, outer]))
    assert (cause.kind, cause.sentence) == ("no_action", "reach had no action for state 1")


@pytest.mark.parametrize(("again", "kind"), [(True, "no_action"), (False, "")])
def test_end_of_a_used_program_is_no_cause_if_its_program_went_on(again: bool, kind: str) -> None:
    inner = {**transition("0", "go", "1", 0.5, 30), "depth": 1, "program": "sub", "use": "reach"}
    outer = transition("0X", "reach", "-X", 0.5, 30)
    later = [transition("-X", "hold", "X0", 1.0, 30)]
    repeated = [{**inner, "time": 1.5}, {**outer, "time": 1.5}] if again else []
    history = made({"outcome": "failure"}, transitions=[inner, outer, *later, *repeated])
    assert getattr(diagnose(history).cause, "kind", "") == kind


@pytest.mark.parametrize("word", ["Interrupted", "Failed"])
def test_halt_is_an_interrupt_or_an_error_of_the_backend(word: str) -> None:
    kind = "interrupted" if word == "Interrupted" else "backend"
    assert _first(made({"halted": True, "ending": f"{word} after 2.0 s."})).kind == kind


def test_joint_that_moves_on_behind_its_reference_is_followed() -> None:
    references = np.where(_TICK[:, None] < 60, [0.0, 0.0], [0.5, 0.0])
    creeping = np.clip((_TICK[:, None] - 60) / 60, 0.0, 1.0) * [0.05, 0.0]
    assert "not_followed" in _kinds(made(references=references))
    assert "not_followed" not in _kinds(made(references=references, positions=creeping))


@pytest.mark.parametrize(("turn", "found"), [(0.5, True), (0.0, False)], ids=["carries", "stays"])
def test_object_seen_to_stay_where_a_hand_carried_it_away_is_a_doubt(
    turn: float, found: bool
) -> None:
    positions = np.clip((_TICK[:, None] - 60) / 60, 0.0, 1.0) * [turn, 0.0]
    history = made(
        predicates=predicates(("0XX", 30), ("X1X", 90)),
        positions=positions,
        references=positions,
        signal_stereo__red=np.tile([1.0, 0.02, 0.0], (TICKS, 1)),
    )
    assert any("was seen to stay" in each.clause for each in doubts(history)) == found


@pytest.mark.parametrize(("place", "found"), [(0.2, True), (0.8, False)], ids=["between", "beside"])
def test_hand_that_closed_on_a_seen_object_and_felt_nothing_is_a_doubt(
    place: float, found: bool
) -> None:
    # One finger is at the shoulder, the other at the tip of the arm, which folds.
    robot = {**made().summary["robot"], "cells": {"hand.thumb": "pad", "hand.finger": "upper"}}
    positions = np.clip((_TICK[:, None] - 60) / 25, 0.0, 1.0) * [0.0, 2.8]
    changes = {**_MISS, "signal_stereo__red": np.tile([place, 0.1, 0.0], (TICKS, 1))}
    history = made(
        **changes,
        robot=robot,
        positions=positions,
        references=positions,
        level_priority=_acting(0, -1, 1),
    )
    assert any("and felt nothing" in each.clause for each in doubts(history)) == found
