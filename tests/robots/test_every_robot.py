"""Every robot file suffices: its arms take postures and reach, with all optional parts or none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.checking.program import check_program
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Frame, Kinematics
from cbdsl.program.checked import CheckedProgram
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.tick import Tick
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT
from tests.runtime.synthetic import SyntheticBackend

LIBRARY = Library(ROOT)
ROBOTS = {
    name: LIBRARY.read(LIBRARY.locate(RobotDocument, name), RobotDocument).document
    for name in LIBRARY.names(RobotDocument)
}
# Every arm: robot, effector and a posture to go to.
ARMS = [
    pytest.param(robot, name, next(posture for posture in arm.postures if posture != arm.start))
    for robot in ROBOTS.values()
    for name, arm in robot.effectors.items()
    if arm.tip is not None
]
# Programs that reach, of robots other than Dexter, whose programs have tests of their own.
OTHERS = [
    name
    for name in (f"{each}_reach" for each in ROBOTS)
    if (ROOT / "programs" / f"{name}.yaml").exists()
]

STEP = 1e-6


def urdf(robot: RobotDocument) -> Path:
    return ROOT / "robots" / robot.model


def tip(robot: RobotDocument, kinematics: Kinematics, arm: str) -> np.ndarray:
    """Return the position of the tip of an arm."""
    settings = robot.effectors[arm].tip
    assert settings is not None
    frame: Frame = kinematics.frame(settings.link)
    return frame.position + frame.rotation @ np.array(settings.offset)


def played(robot: RobotDocument, program: str, folder: Path) -> tuple[EpisodeResult, np.ndarray]:
    """Run a program's text with joints that follow at once; the result and the last posture."""
    file = folder / "own.yaml"
    head = f"cbdsl: 1\nkind: program\nname: own\nrobot: {robot.name}\n"
    file.write_text(head + program, encoding="utf-8")
    empty: dict[str, Any] = {"cbdsl": 1, "kind": "stage", "name": "empty", "robot": robot.name}
    stage = StageDocument.model_validate({**empty, "contexts": {"only": {}}})
    checked = check_program(file, {}, LIBRARY)
    backend = SyntheticBackend(robot, urdf(robot))
    runner = Runner(robot, Kinematics(robot, urdf(robot)), checked, backend)
    result = runner.run(stage, 0)
    return result, backend.observe().positions


def test_robots_without_cameras_hands_and_head_are_tested() -> None:
    plain = [robot for robot in ROBOTS.values() if not robot.load_cells]
    assert not all(robot.cameras for robot in plain)
    assert len({len(robot.effectors["arm"].joints) for robot in plain}) >= 2


@pytest.mark.parametrize(("robot", "arm", "posture"), ARMS)
def test_arm_takes_a_posture(robot: RobotDocument, arm: str, posture: str, tmp_path: Path) -> None:
    move = f"{{potential: spring, reference: {arm}.{posture}, feedback: {arm}, effector: {arm}}}"
    result, positions = played(
        robot,
        f"controllers:\n  move: {move}\nactions: [move]\npolicy: {{X: move, '0': move}}\n",
        tmp_path,
    )
    assert result.predicates[-1] == "1", result.ending
    own = Kinematics(robot, urdf(robot)).joints.of(arm)
    assert positions[own] == pytest.approx(robot.effectors[arm].postures[posture], abs=0.03)


@pytest.mark.parametrize(("robot", "arm", "posture"), ARMS)
def test_arm_reaches_a_reachable_position(
    robot: RobotDocument, arm: str, posture: str, tmp_path: Path
) -> None:
    kinematics = Kinematics(robot, urdf(robot))
    there = np.zeros(len(kinematics.joints))
    there[kinematics.joints.of(arm)] = robot.effectors[arm].postures[posture]
    kinematics.update(there)
    goal = tip(robot, kinematics, arm)
    reference = ", ".join(f"{value:.6f}" for value in goal)
    reach = (
        f"{{potential: spring, reference: [{reference}], "
        f"feedback: {arm}.position, effector: {arm}.position}}"
    )
    result, positions = played(
        robot,
        f"controllers:\n  reach: {reach}\nactions: [reach]\npolicy: {{X: reach, '0': reach}}\n",
        tmp_path,
    )
    assert result.predicates[-1] == "1", result.ending
    kinematics.update(positions)
    assert tip(robot, kinematics, arm) == pytest.approx(goal, abs=0.005)


@pytest.mark.parametrize(("robot", "arm", "posture"), ARMS)
def test_tips_jacobian_by_finite_differences(robot: RobotDocument, arm: str, posture: str) -> None:
    kinematics = Kinematics(robot, urdf(robot))
    settings = robot.effectors[arm].tip
    assert settings is not None
    q = np.zeros(len(kinematics.joints))
    q[kinematics.joints.of(arm)] = robot.effectors[arm].postures[posture]
    kinematics.update(q)
    lever = kinematics.frame(settings.link).rotation @ np.array(settings.offset)
    jacobian = kinematics.jacobian(settings.link)
    linear = jacobian[:3] + np.cross(jacobian[3:].T, lever).T
    moved = []
    for change in STEP * np.eye(len(q)):
        kinematics.update(q + change)
        ahead = tip(robot, kinematics, arm)
        kinematics.update(q - change)
        moved.append((ahead - tip(robot, kinematics, arm)) / (2 * STEP))
    assert linear == pytest.approx(np.array(moved).T, abs=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("name", OTHERS)
def test_programs_of_other_robots_run_on_the_simulator(name: str) -> None:
    program: CheckedProgram = check_program(name, {}, LIBRARY)
    robot = ROBOTS[program.robot]
    stage_file = LIBRARY.locate(StageDocument, program.stage or "")
    stage = LIBRARY.read(stage_file, StageDocument).document
    potentials: dict[str, list[float]] = {}

    def note(tick: Tick) -> None:
        for run in tick.run.runs:
            if not np.isnan(run.phi):
                potentials.setdefault(run.controller.name, []).append(run.phi)

    backend = BulletBackend(robot, urdf(robot))
    runner = Runner(robot, Kinematics(robot, urdf(robot)), program, backend)
    result = runner.run(stage, 0, observer=EpisodeListeners(on_tick=note))
    backend.close()
    assert result.predicates[-1] == "X11", result.ending
    # The reach is kept while the arm becomes more manipulable.
    assert potentials["reach"][-1] < 1e-5
    first, last = potentials["condition"][0], potentials["condition"][-1]
    assert last < 1.02 * first < 0
