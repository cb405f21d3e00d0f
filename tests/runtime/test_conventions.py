"""Conventions that docs/documents states: how an orientation is written, and an effector."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.checking.program import check_program
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.tick import Tick
from cbdsl.yaml_text.library import Library

GO = """\
cbdsl: 1
kind: program
name: go
robot: dexter
stage: absent
controllers:
  go: {{potential: spring, reference: {reference}, feedback: {feedback}, effector: {effector}}}
actions: [go]
policy: {{X: go, 0: go}}
"""

Go = Callable[[str, str, str], tuple[EpisodeResult, np.ndarray, np.ndarray]]


@pytest.fixture
def go(
    library: Library,
    dexter: RobotDocument,
    urdf: Path,
    kinematics: Kinematics,
    stage: Callable[[str], StageDocument],
    tmp_path: Path,
) -> Go:
    """Run one controller to its rest; the joints meanwhile, and the feedback at the end."""

    def run(reference: str, feedback: str, effector: str) -> tuple:
        file = tmp_path / "go.yaml"
        text = GO.format(reference=reference, feedback=feedback, effector=effector)
        file.write_text(text, "utf-8")
        program = check_program(file, {}, Library(tmp_path))
        resource = program.actions[0].composition.primitives[0].controllers[0].feedback
        backend = KinematicBackend(dexter, urdf)
        joints, last = [], []

        def note(tick: Tick) -> None:
            joints.append(tick.observation.positions.copy())
            last[:] = [tick.signals.read(resource).value.copy()]

        result = Runner(dexter, kinematics, program, backend).run(
            stage("absent"), 0, observer=EpisodeListeners(on_tick=note)
        )
        backend.close()
        return result, np.array(joints), last[0]

    return run


def turn(axis: int, angle: float) -> np.ndarray:
    """Return the rotation matrix about an axis of the world."""
    one, other = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[one, one] = matrix[other, other] = math.cos(angle)
    matrix[other, one], matrix[one, other] = math.sin(angle), -math.sin(angle)
    return matrix


def test_orientation_is_a_rotation_vector_and_no_roll_pitch_and_yaw(go: Go) -> None:
    result, _, reached = go(
        "[120 deg, 120 deg, 0 deg]", "right_arm.orientation", "right_arm.orientation"
    )
    assert result.predicates[-1] == "1"
    # Half of the way about each of two axes: about the diagonal by sqrt(2) of it.
    angle = math.radians(120) * math.sqrt(2)
    diagonal = turn(2, math.pi / 4) @ turn(0, angle) @ turn(2, -math.pi / 4)
    assert reached == pytest.approx(diagonal, abs=0.02)
    fixed_axes = turn(1, math.radians(120)) @ turn(0, math.radians(120))
    assert np.abs(reached - fixed_axes).max() > 0.5


def test_pose_is_a_position_and_then_a_rotation_vector(go: Go) -> None:
    reference = "[50 cm, -25 cm, -5 cm, 120 deg, 120 deg, 0 deg]"
    settings = "gain: 8 /s, quiescence: {rate: 1.0e-4, window: 0.3 s}"
    result, _, reached = go(reference, "right_arm.pose", f"right_arm.pose, {settings}")
    assert result.predicates[-1] == "1"
    angle = math.radians(120) * math.sqrt(2)
    diagonal = turn(2, math.pi / 4) @ turn(0, angle) @ turn(2, -math.pi / 4)
    assert reached[:3, :3] == pytest.approx(diagonal, abs=0.02)
    assert reached[:3, 3] == pytest.approx([0.5, -0.25, -0.05], abs=0.01)


def test_effector_and_its_position_move_alike(go: Go) -> None:
    place = "[50 cm, -25 cm, -5 cm]"
    (one, joints, _), (other, same, _) = (
        go(place, "right_arm.position", effector)
        for effector in ("right_arm", "right_arm.position")
    )
    assert one.predicates == other.predicates
    assert np.array_equal(joints, same) and np.ptp(joints, axis=0).max() > 0.1
