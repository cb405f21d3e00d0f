"""Guards of joint torques give way to contacts of any link of an arm."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pybullet
import pytest

from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.checking.program import check_program
from cbdsl.cli.output.narration import StackNarration
from cbdsl.documents.robot import JointTorques, RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.program.checked import Guards
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.tick import Tick
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.touch.touch import Strain
from cbdsl.yaml_text.library import Library

PROGRAM = """
cbdsl: 1
kind: program
name: push
robot: dexter
stage: post
controllers:
  go:
    potential: spring
    reference: here + [35 cm, 0 cm, 0 cm]
    feedback: right_arm.position
    effector: right_arm.position
actions: [go]
policy: {"*": go}
limits: {transition_time: 4 s}
"""
STAGE = """
cbdsl: 1
kind: stage
name: post
robot: dexter
fixtures:
  post: {form: {shape: box, size: [6 cm, 6 cm, 40 cm]}, position: [30 cm, -55 cm, 6 cm]}
contexts:
  there: {things: []}
"""


def observed(time: float, positions: np.ndarray, efforts: np.ndarray | None) -> Observation:
    return Observation(time, positions, np.zeros_like(positions), {}, {}, efforts=efforts)


def test_strain_is_the_drive_torque_minus_the_weight(kinematics: Kinematics) -> None:
    strain = Strain(JointTorques(filter=0.05), kinematics)
    q = np.zeros(len(kinematics.joints))
    kinematics.update(q)
    pressed = np.arange(len(q)) / 10
    weight = kinematics.weight()
    assert np.abs(weight).max() > 1.0
    for tick in range(60):
        strain.update(observed(tick / 60, q, weight + pressed))
    assert not strain.torques.any(), "nobody needs it"
    strain.needed = True
    strain.update(observed(1.0, q, weight + pressed))
    assert not strain.torques.any(), "before the first step no drive has exerted anything"
    strain.update(observed(1.05, q, weight + pressed))
    np.testing.assert_allclose(strain.torques, (1 - np.exp(-1)) * pressed, atol=1e-9)
    for tick in range(60):
        strain.update(observed(1.06 + tick / 60, q, weight + pressed))
    np.testing.assert_allclose(strain.torques, pressed, atol=1e-6)
    strain.reset()
    strain.update(observed(0.0, q, None))
    assert not strain.torques.any()


def test_weight_is_the_slope_of_the_potential_energy(kinematics: Kinematics) -> None:
    """Compare with the energy of the model's masses, posture by posture."""
    rng = np.random.default_rng(4)
    q = rng.uniform(np.maximum(kinematics.lower, -2), np.minimum(kinematics.upper, 2))
    kinematics.update(q)
    weight, arm = kinematics.weight(), kinematics.joints.of("right_arm")
    for joint in arm:
        energies = []
        for side in (1e-5, -1e-5):
            moved = q.copy()
            moved[joint] += side
            energies.append(_energy(kinematics, moved))
        assert weight[joint] == pytest.approx((energies[0] - energies[1]) / 2e-5, abs=1e-4)


def _energy(kinematics: Kinematics, q: np.ndarray) -> float:
    """Return the potential energy, J, of the links by the places of their joints."""
    kinematics.update(q)
    model, energy = kinematics._model, 0.0
    joints = tuple(name for name in model.names if name != "universe")
    kinematics.origins(joints, ())
    for number in range(1, model.njoints):
        own, frame = model.inertias[number], kinematics.frames[number]
        centre = frame[9:] + frame[:9].reshape(3, 3) @ own.lever
        energy += own.mass * 9.81 * float(centre[2])
    return energy


def _push(
    folder: Path, robot: RobotDocument, urdf: Path, guards: Guards, told: list[str]
) -> tuple[EpisodeResult, list[float]]:
    """Run an episode, and return it with the true force on the post tick by tick, N."""
    for name, text in (("programs/push", PROGRAM), ("programs/stages/post", STAGE)):
        file = folder / f"{name}.yaml"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    library = Library(folder)
    program = check_program(str(folder / "programs/push.yaml"), {}, library)._replace(guards=guards)
    stage = library.read(folder / "programs/stages/post.yaml", StageDocument).document
    backend, stack, forces = BulletBackend(robot, urdf, cameras="ideal"), StackNarration(), []

    def note(tick: Tick) -> None:
        stack.note_tick(tick)
        bodies, client = backend.truth.bodies, backend.truth.client
        points = pybullet.getContactPoints(
            bodyB=bodies["post"], bodyA=backend.truth.robot.id, physicsClientId=client
        )
        forces.append(sum(point[9] for point in points))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("builtins.print", lambda text, **_: told.append(text))
        runner = Runner(robot, Kinematics(robot, urdf), program, backend)
        result = runner.run(stage, 8_000_501, observer=EpisodeListeners(on_tick=note))
    backend.close()
    return result, forces


@pytest.mark.slow
def test_arm_gives_way_where_no_cell_feels_anything(
    tmp_path: Path, dexter: RobotDocument, urdf: Path
) -> None:
    told: list[str] = []
    free, forces = _push(tmp_path, dexter, urdf, Guards(), told)
    assert np.mean(forces[-60:]) > 100.0, "it presses on"
    assert free.guards == () and not any("gave way" in line for line in told)
    guarded, eased = _push(tmp_path, dexter, urdf, Guards(joint_torque=20.0), told)
    assert np.mean(eased[-60:]) < 50.0
    (clause,) = guarded.guards
    assert clause.startswith("the guard of right_arm (20 N m) held for")
    assert clause in guarded.ending
    assert any("gave way to guards, share of the ticks: right_arm" in line for line in told)
