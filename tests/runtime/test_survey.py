"""``survey`` refuses before motion, with a reason, by sizes that the cameras measure."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.backend import embody
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl.runtime.tick import Tick
from tests.backends.conftest import stage_named
from tests.conftest import Checked


@pytest.fixture(scope="module")
def backend(dexter: RobotDocument, urdf: Path) -> Iterator[object]:
    backend = embody("kinematic", dexter, urdf)
    yield backend
    backend.close()


@pytest.fixture(scope="module")
def objects() -> StageDocument:
    return stage_named("everyday_objects")


@pytest.mark.parametrize(
    ("context", "reason"),
    [
        ("parcel", "wider than the hand"),
        ("medicine_ball", "wider than the hand"),
        ("die", "too small for the fingers"),
        ("softball", ""),
        ("matchbox", ""),
        ("cereal_box", "too heavy for the hand if it is full"),
        ("paperback", "too flat for its width"),
        ("hammer", "too long for one hand"),
        ("screwdriver", ""),
    ],
)
@pytest.mark.parametrize("seed", [61_000, 61_001])
def test_survey_of_an_object_names_the_reason_of_a_refusal_and_moves_no_arm(
    context: str, reason: str, seed: int, backend: object, objects: StageDocument,
    dexter: RobotDocument, kinematics: Kinematics, checked: Checked,
) -> None:  # fmt: skip
    runner = Runner(dexter, kinematics, checked("survey"), backend)  # type: ignore[arg-type]
    postures: list[np.ndarray] = []

    def note(tick: Tick) -> None:
        postures.append(tick.observation.positions[tick.signals.joints.of("right_arm")])

    result = runner.run(objects, seed, context, observer=EpisodeListeners(on_tick=note))
    assert result.outcome == ("failure" if reason else "success"), result.ending
    assert reason in result.ending
    assert np.ptp(postures, axis=0).max() < 0.02


@pytest.mark.parametrize(
    ("context", "seed", "reason"),
    [
        ("parcel", 90_302, ""),
        ("parcel", 90_303, "out of reach of the left hand"),
        ("paint_can", 90_301, ""),
        ("play_ball", 90_301, "may roll away between the hands"),
        ("tray", 90_301, "too low for both hands"),
        ("cereal_box", 90_301, "no wider than one hand"),
        ("softball", 90_301, "no wider than one hand"),
    ],
)
def test_survey_for_both_accepts_large_objects_within_reach_and_moves_no_arm(
    context: str, seed: int, reason: str, backend: object, objects: StageDocument,
    dexter: RobotDocument, kinematics: Kinematics, checked: Checked,
) -> None:  # fmt: skip
    runner = Runner(dexter, kinematics, checked("survey_for_both"), backend)  # type: ignore[arg-type]
    postures: list[np.ndarray] = []

    def note(tick: Tick) -> None:
        joints = tick.signals.joints
        arms = [*joints.of("right_arm"), *joints.of("left_arm")]
        postures.append(tick.observation.positions[arms])

    result = runner.run(objects, seed, context, observer=EpisodeListeners(on_tick=note))
    assert result.outcome == ("failure" if reason else "success"), result.ending
    assert reason in result.ending
    assert np.ptp(postures, axis=0).max() < 0.02


def test_survey_with_a_larger_margin_refuses_an_object_within_the_hand(
    backend: object, objects: StageDocument, dexter: RobotDocument, kinematics: Kinematics,
    checked: Checked,
) -> None:  # fmt: skip
    """The bound comes from the hand's own opening, not from a number for the objects."""
    program = checked("survey", margin="20 cm")
    runner = Runner(dexter, kinematics, program, backend)  # type: ignore[arg-type]
    result = runner.run(objects, 61_000, "softball")
    assert result.outcome == "failure" and "wider than the hand" in result.ending
