"""Causes that keep a level from its target, against arms in known postures and a search."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import pytest

from cbdsl.control.law import Law, LawSettings
from cbdsl.control.level import Level
from cbdsl.numeric.arrays import Floats
from cbdsl.runtime.causes import CREEPING, HELD, LIMITS, OPTIMUM, SINGULAR, Balance, RestCause
from tests.conftest import ROOT
from tests.control.chain import Chain

_LENGTH, _LIMIT, _FRACTION = 0.9, 2.0, 0.067


def cause(
    q: list[float], aim: tuple[float, float], *above: str, limit: float = _LIMIT
) -> RestCause | None:
    """Return the cause of a planar arm's position level below other levels, at a posture.

    Args:
        q: Joint positions, rad.
        aim: Target of the tip in the plane, m.
        above: Higher levels: ``turn`` and ``home`` keep the orientation and the first joint.
        limit: Largest joint position, rad.
    """
    posture, count = np.array(q), len(q)
    chain = Chain.planar(count, _LENGTH)
    position, _, rows = chain.pose(posture)
    hessian = chain.hessian(posture)
    away: Floats = np.array(aim) - position[:2]
    kept = {"turn": rows[5:], "home": np.eye(count)[:1]}
    levels = [Level(name, kept[name], np.zeros(1), np.zeros((1, count, count))) for name in above]
    levels.append(Level("move", rows[:2], _FRACTION * away, hessian[:2], _FRACTION))
    law = Law(np.full(count, -limit), np.full(count, limit), LawSettings(0.05))
    step = law.solve(levels, posture)
    outward = np.where(step.locked, np.sign(posture), 0.0)
    names = [f"j{joint}" for joint in range(count)]
    return Balance(step, [level.name for level in levels], names, outward).cause(len(above))


def test_cause_of_an_arm_stretched_to_a_far_target_is_an_optimum() -> None:
    assert cause([0.0, 0.0, 0.0], (1.4, 0.0)) == RestCause(OPTIMUM)


def test_cause_of_an_arm_stretched_over_its_target_is_a_singular_posture() -> None:
    assert cause([0.0, 0.0, 0.0], (0.4, 0.0)) == RestCause(SINGULAR)


def test_cause_of_a_joint_at_its_limit_names_it() -> None:
    limit = 0.5
    found = cause([limit - 0.01], (-0.2, 0.8), limit=limit)
    assert found == RestCause(LIMITS, (LIMITS,), ("j0",))


@pytest.mark.parametrize("above", ["turn", "home"])
def test_cause_of_a_level_without_freedom_is_the_level_above(above: str) -> None:
    assert cause([0.3], (0.2, 0.8), above) == RestCause(HELD, (above,))


def test_cause_of_a_level_that_two_hold_names_both() -> None:
    """Each of them leaves one of two joints: only both together stop the arm."""
    found = cause([0.3, 0.5], (-0.5, -0.2), "turn", "home")
    assert found is not None and found.kind == HELD and set(found.holders) == {"turn", "home"}


def test_cause_of_a_level_that_moves_has_no_holder() -> None:
    found = cause([0.3, 0.6, 0.4], (0.5, 0.5))
    assert found is not None and (found.kind, found.holder) == (CREEPING, "")


def test_cause_of_a_level_without_a_request_is_unknown() -> None:
    position = Chain.planar(3, _LENGTH).pose(np.array([0.3, 0.6, 0.4]))[0]
    assert cause([0.3, 0.6, 0.4], (position[0], position[1])) is None


def judge(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    return importlib.import_module("true_endings")


@pytest.mark.parametrize("arm", [40, 43])
def test_endings_of_reaches_state_nothing_false(arm: int, monkeypatch: pytest.MonkeyPatch) -> None:
    false: list[str] = []
    seen, _ = judge(monkeypatch).endings([arm], 5, false.append)
    assert not false and seen.total() == 5


@pytest.mark.slow
def test_endings_of_many_reaches_state_nothing_false(monkeypatch: pytest.MonkeyPatch) -> None:
    false: list[str] = []
    seen, _ = judge(monkeypatch).endings(range(50, 54), 5, false.append)
    assert not false and len(seen) >= 3
