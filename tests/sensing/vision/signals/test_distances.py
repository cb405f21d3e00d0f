"""Distances of seen objects from the first joints of effectors."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.backend import embody
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.resources import resources
from cbdsl.sensing.signals import Signals

StageNamed = Callable[[str], StageDocument]
FIRST = {"left_arm": "left_arm_1", "right_arm": "right_arm_1"}


@pytest.fixture
def signals(
    dexter: RobotDocument, urdf: Path, kinematics: Kinematics, stage: StageNamed
) -> Signals:
    """Return signals of a robot that sees a red object."""
    known = resources(dexter)
    backend = embody("kinematic", dexter, urdf, cameras="ideal")
    signals = Signals(dexter, kinematics, [known[f"stereo.{name}"] for name in ("red", "yellow")])
    backend.reset(stage("stacked"), None, np.random.default_rng(0))
    for _ in range(25):
        signals.update(backend.observe())
        backend.apply(signals.positions.copy())
        backend.step()
    backend.close()
    return signals


def distance(signals: Signals, effector: str) -> float:
    reading = signals.read(resources(signals.robot)[f"stereo.red.from.{effector}"])
    assert reading is not None
    return float(reading.value[0])


@pytest.mark.parametrize("arm", FIRST)
def test_distance_is_measured_from_the_first_joint_of_an_arm(signals: Signals, arm: str) -> None:
    place = signals.read(resources(signals.robot)["stereo.red"])
    assert place is not None
    (base,) = signals.kinematics.origins((FIRST[arm],), ())
    assert distance(signals, arm) == pytest.approx(np.linalg.norm(place.value - base))


def test_distance_from_a_group_is_the_least_of_its_members(signals: Signals) -> None:
    assert distance(signals, "arms") == min(distance(signals, arm) for arm in FIRST)


def test_distance_is_undefined_without_an_object(signals: Signals) -> None:
    assert signals.read(resources(signals.robot)["stereo.yellow.from.arms"]) is None


def test_distance_does_not_depend_on_the_posture_of_the_arm(signals: Signals) -> None:
    before = distance(signals, "arms")
    signals.kinematics.update(np.full(len(signals.joints), 0.1))
    assert distance(signals, "arms") == pytest.approx(before)
