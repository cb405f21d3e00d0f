"""A camera beside a stereo pair changes nothing that the pair sees, and sees by itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.resources import resources
from cbdsl.sensing.signals import Signals
from tests.runtime.conftest import made_stage
from tests.runtime.synthetic import Ball, SyntheticBackend

PLACES = [np.array(each) for each in ((0.75, -0.25, -0.35), (0.8, 0.1, -0.35), (0.9, 0.0, -0.4))]
PAIR = ("stereo.red", "cameras.red", "cyclopean.red", "count.red", "left.red", "right.red")


def with_third(robot: RobotDocument, pair: tuple[str, str] | None) -> RobotDocument:
    """Return a robot with another camera, listed first, at the place of its left one."""
    third = robot.cameras["left"].model_copy(update={"focal_length": 300.0})
    vision = robot.vision.model_copy(update={"stereo": pair})
    return robot.model_copy(update={"cameras": {"third": third, **robot.cameras}, "vision": vision})


def read(
    robot: RobotDocument, urdf: Path, place: np.ndarray, names: tuple[str, ...]
) -> dict[str, np.ndarray | None]:
    """Return the readings of a robot, half a second after a ball is placed."""
    named = {name: resources(robot)[name] for name in names}
    backend = SyntheticBackend(robot, urdf)
    signals = Signals(robot, Kinematics(robot, urdf), named.values())
    rows = {name: signals.bind(each) for name, each in named.items()}
    away = place - signals.kinematics.frame("left_camera").position
    pan, tilt = np.arctan2(place[1], place[0]), np.arctan2(-away[2], np.hypot(*away[:2]))
    backend.reset(made_stage({"pan": pan, "tilt": tilt}), None, np.random.default_rng(0))
    backend.world.ball = Ball(place.copy())
    selection = signals.select(rows.values())
    for _ in range(60):
        signals.update(backend.observe())
        signals.refresh(selection)
        backend.apply(signals.positions)
        backend.step()
    readings = {name: signals.reading(row, named[name].type.name) for name, row in rows.items()}
    return {name: None if each is None else each.value for name, each in readings.items()}


@pytest.mark.parametrize("place", PLACES, ids=str)
def test_named_pair_reads_as_without_the_other_camera(
    dexter: RobotDocument, urdf: Path, place: np.ndarray
) -> None:
    alone = read(dexter, urdf, place, PAIR)
    beside = read(with_third(dexter, ("left", "right")), urdf, place, (*PAIR, "third.red"))
    assert alone["stereo.red"] is not None
    for name in PAIR:
        np.testing.assert_array_equal(beside[name], alone[name], name)
    # The other camera is at the left one's place, with another focal length.
    assert beside["third.red"] == pytest.approx(alone["left.red"], abs=0.01)


def test_three_cameras_without_a_pair_have_no_stereo(dexter: RobotDocument) -> None:
    named = resources(with_third(dexter, None))
    assert "third.red" in named and "cyclopean.red" in named
    assert not [each for each in named if each.partition(".")[0] in ("stereo", "cameras", "count")]


def test_any_two_of_three_cameras_triangulate(dexter: RobotDocument, urdf: Path) -> None:
    usual = read(dexter, urdf, PLACES[0], ("stereo.red",))["stereo.red"]
    for pair in (("third", "right"), ("right", "left")):
        seen = read(with_third(dexter, pair), urdf, PLACES[0], ("stereo.red",))["stereo.red"]
        assert seen == pytest.approx(usual, abs=0.01), pair
