"""``find_the_other`` touches both of two things of one colour, and the second is not the first."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl.runtime.tick import Tick
from tests.conftest import Checked


@pytest.mark.parametrize("seed", range(70001, 70005))
def test_find_the_other_touches_two_objects_in_turn(
    dexter: RobotDocument,
    urdf: Path,
    kinematics: Kinematics,
    checked: Checked,
    stage: Callable[[str], StageDocument],
    seed: int,
) -> None:
    backend = KinematicBackend(dexter, urdf)
    touched: list[str] = []

    def note(_: Tick) -> None:
        touched.extend(name for name in ("one", "other") if backend.truth.touched(name))

    runner = Runner(dexter, kinematics, checked("find_the_other"), backend)
    result = runner.run(stage("two_red_balls"), seed, observer=EpisodeListeners(on_tick=note))
    backend.close()
    assert result.rewarded, result.ending
    assert set(touched) == {"one", "other"}
    assert touched[0] != touched[-1]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [5300003, 5300016])
def test_hand_that_withdraws_spoils_nothing(
    dexter: RobotDocument,
    urdf: Path,
    kinematics: Kinematics,
    checked: Checked,
    stage: Callable[[str], StageDocument],
    seed: int,
) -> None:
    """Allow the second ball to appear first behind the hand, or on the way home."""
    backend = BulletBackend(dexter, urdf, cameras="rendered")
    runner = Runner(dexter, kinematics, checked("find_the_other"), backend)
    result = runner.run(stage("two_red_balls"), seed)
    backend.close()
    assert result.rewarded, result.ending
