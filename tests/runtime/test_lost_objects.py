"""An object that leaves the world ends a program, in a sentence that names it."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.runtime.episode import Runner
from tests.backends.conftest import stage_named
from tests.conftest import Checked


@pytest.mark.parametrize("lost_time", [5.0, 8.0])
def test_program_run_fails_once_its_object_is_lost_for_long(
    checked: Checked, dexter: RobotDocument, kinematics: Kinematics, urdf: Path, lost_time: float
) -> None:
    program = checked("take_and_put_down", feature="red")._replace(lost_time=lost_time)
    backend = KinematicBackend(dexter, urdf)
    result = Runner(dexter, kinematics, program, backend).run(stage_named("thrown"), 1)
    backend.close()
    assert result.outcome == "failure"
    assert f"the object of red is gone: last seen {lost_time:.1f} s before" in result.ending
    # It is thrown after 1 to 2 s, and seen for some time on its way.
    assert lost_time + 1.0 <= result.sim_seconds <= lost_time + 5.0


def test_program_run_without_such_a_limit_searches_on(
    checked: Checked, dexter: RobotDocument, kinematics: Kinematics, urdf: Path
) -> None:
    program = checked("take_and_put_down", feature="red")._replace(
        lost_time=None, episode_time=12.0
    )
    backend = KinematicBackend(dexter, urdf)
    result = Runner(dexter, kinematics, program, backend).run(stage_named("thrown"), 1)
    backend.close()
    assert result.outcome == "" and result.sim_seconds == pytest.approx(12.0, abs=0.1)
    assert "the object of red is gone" in result.ending
