"""Vision: objects in both cameras have a position, and lost ones are forgotten unless hidden."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.resources import resources
from cbdsl.sensing.channels import ChannelFilter, Moments, Region
from cbdsl.sensing.signals import Signals
from tests.runtime.conftest import made_stage
from tests.runtime.synthetic import RED, Ball, SyntheticBackend

BALL = np.array([0.75, -0.25, -0.35])
GREEN = (0, 255, 0)
FINGERTIPS = tuple(f"right_finger_{number}_tip" for number in (1, 2, 3))


@pytest.fixture(scope="module")
def backend(dexter: RobotDocument, urdf: Path) -> SyntheticBackend:
    return SyntheticBackend(dexter, urdf)


@pytest.fixture
def signals(dexter: RobotDocument, kinematics: Kinematics, backend: SyntheticBackend) -> Signals:
    """Return signals that observe red and green objects."""
    named = resources(dexter)
    backend.reset(made_stage({"pan": -0.35, "tilt": 0.9}), None, np.random.default_rng(0))
    return Signals(dexter, kinematics, [named["stereo.red"], named["stereo.green"]])


def look(backend: SyntheticBackend, signals: Signals, seconds: float = 0.1) -> None:
    for _ in range(round(seconds / backend.control_period)):
        signals.update(backend.observe())
        backend.apply(signals.positions)
        backend.step()


def look_towards(
    point: NDArray[np.float64], backend: SyntheticBackend, signals: Signals, **joints: float
) -> None:
    """Begin anew with the head turned to a point, and these joints, rad."""
    head = signals.kinematics.frame("left_camera").position
    turn = np.arctan2(point[1], point[0])
    down = np.arctan2(head[2] - point[2], np.hypot(*(point - head)[:2]))
    backend.reset(made_stage({"pan": turn, "tilt": down, **joints}), None, np.random.default_rng(0))
    signals.reset()
    signals.update(backend.observe())


def moves(signals: Signals) -> bool:
    """Return True if motion is seen, or was a moment ago."""
    return signals.vision.heading("left", "motion") is not None


def test_motion_lasts_until_the_camera_rests_again(
    dexter: RobotDocument, kinematics: Kinematics, backend: SyntheticBackend
) -> None:
    signals = Signals(dexter, kinematics, [resources(dexter)["cyclopean.motion"]])
    look_towards(BALL, backend, signals)
    backend.world.ball = Ball(BALL.copy())
    look(backend, signals, 0.5)
    assert not moves(signals)
    for _ in range(3):
        backend.world.ball.position[1] += 0.02
        look(backend, signals)
    assert moves(signals)
    first, pan = signals.vision.heading("left", "motion"), kinematics.joints.index["pan"]
    assert first is not None
    # All regions move in the images of a head that turns, for longer than a moment; regions
    # that moved before stay at their place in the world.
    for _ in range(60):
        signals.update(backend.observe())
        backend.apply(signals.positions + np.eye(len(signals.positions))[pan] * 0.003)
        backend.step()
    turned = signals.vision.heading("left", "motion")
    assert turned is not None
    # A camera that looks down sees the cosine of the turn about the vertical.
    seen = -0.18 * np.cos(signals.positions[kinematics.joints.index["tilt"]])
    assert turned.angles[0] - first.angles[0] == pytest.approx(seen, abs=0.03)
    look(backend, signals, 0.5)
    assert not moves(signals)


def position(signals: Signals, channel: str) -> NDArray[np.float64] | None:
    return signals.vision.memories[channel].position


def region(signals: Signals, camera: str) -> Any:
    """Return the red region in a camera."""
    return signals.vision.region(camera, "red")


def headings(signals: Signals) -> list[list[float]]:
    """Return the headings to red in both cameras."""
    seen = [signals.vision.heading(camera, "red") for camera in ("left", "right")]
    return [each.angles.tolist() for each in seen if each is not None]


@pytest.mark.parametrize("radius", [0.03, 0.06, 0.09])
@pytest.mark.parametrize("shift", [(0, 0, 0), (0.1, -0.05, 0), (-0.05, 0.08, 0.1)])
def test_ball_is_triangulated_at_its_place(
    backend: SyntheticBackend, signals: Signals, radius: float, shift: tuple[float, float, float]
) -> None:
    centre = BALL + shift
    backend.world.ball = Ball(centre, radius)
    look(backend, signals)
    assert position(signals, "red") == pytest.approx(centre, abs=0.01)
    assert signals.vision.memories["red"].radius == pytest.approx(radius, rel=0.05)
    assert position(signals, "green") is None


def test_each_channel_has_its_own_memory(backend: SyntheticBackend, signals: Signals) -> None:
    other = BALL + np.array([0.1, 0.05, 0])
    for color, centre in ((RED, BALL), (GREEN, other)):
        backend.world.ball = Ball(centre, 0.05, color)
        look(backend, signals)
    assert position(signals, "red") == pytest.approx(BALL, abs=0.01)
    assert position(signals, "green") == pytest.approx(other, abs=0.01)


def test_object_that_vanishes_in_view_is_forgotten(
    backend: SyntheticBackend, signals: Signals, dexter: RobotDocument
) -> None:
    backend.world.ball = Ball(BALL)
    look(backend, signals)
    backend.world.ball = None
    look(backend, signals, dexter.vision.regions.hold - 0.1)
    assert position(signals, "red") == pytest.approx(BALL, abs=0.01)
    look(backend, signals, 0.3)
    assert position(signals, "red") is None


def test_object_behind_a_hand_is_remembered(
    backend: SyntheticBackend, signals: Signals, dexter: RobotDocument
) -> None:
    """Place the palm on the line of sight."""
    signals.update(backend.observe())
    palm = signals.kinematics.frame("right_palm").position
    head = signals.kinematics.frame("left_camera").position
    behind = palm + 0.05 * (palm - head) / np.linalg.norm(palm - head)
    look_towards(behind, backend, signals)
    backend.world.ball = Ball(behind, 0.04)
    look(backend, signals)
    assert position(signals, "red") == pytest.approx(behind, abs=0.01)
    backend.world.ball = None
    look(backend, signals, 10 * dexter.vision.regions.hold)
    assert position(signals, "red") == pytest.approx(behind, abs=0.01)


@pytest.mark.parametrize(
    ("share", "force", "is_there"), [(0.7, 0.0, False), (0.8, 0.0, True), (0.7, 1.0, True)]
)
def test_object_in_a_closed_hand_is_forgotten_without_contact(
    backend: SyntheticBackend, signals: Signals, share: float, force: float, is_there: bool
) -> None:
    closed = {f"right_finger_{number}": 1.6 for number in (1, 2, 3)}
    look_towards(BALL, backend, signals, **closed)
    tips = signals.kinematics.origins((), FINGERTIPS)
    middle = tips.mean(axis=0)
    look_towards(middle, backend, signals, **closed)
    radius = np.linalg.norm(tips - middle, axis=1).max() / share
    backend.world.ball = Ball(middle, radius)
    look(backend, signals)
    assert position(signals, "red") == pytest.approx(middle, abs=0.01)
    backend.world.ball = None
    backend.world.broken["right_hand", "finger_1"] = np.array([0.0, 0, force, 0, 0, 0])
    look(backend, signals)
    assert (position(signals, "red") is not None) == is_there


def test_ball_that_is_cut_off_by_the_border_has_a_heading_but_no_position(
    backend: SyntheticBackend, signals: Signals
) -> None:
    signals.update(backend.observe())
    camera = signals.kinematics.frame("left_camera")
    half_width = 160 / 418.5
    edge = camera.position + camera.rotation @ np.array([1.0, half_width, 0.0])
    backend.world.ball = Ball(edge, 0.08)
    look(backend, signals)
    assert signals.vision.heading("left", "red") is not None
    assert region(signals, "left").clipped
    assert position(signals, "red") is None


def test_heading_outlives_its_region_without_a_new_stamp(
    backend: SyntheticBackend, signals: Signals, dexter: RobotDocument
) -> None:
    heading = resources(dexter)["left.red"]
    backend.world.ball = Ball(BALL)
    look(backend, signals)
    seen = signals.read(heading)
    assert seen is not None
    backend.world.ball = None
    look(backend, signals, dexter.vision.regions.linger / 2)
    kept = signals.read(heading)
    assert kept is not None
    assert kept.value == pytest.approx(seen.value, abs=1e-3)
    assert kept.stamp == seen.stamp < signals.vision.images
    look(backend, signals, dexter.vision.regions.linger)
    assert signals.read(heading) is None


def test_regions_of_ideal_cameras_are_filtered_like_images(
    backend: SyntheticBackend, signals: Signals, dexter: RobotDocument
) -> None:
    """Ignore regions that are too small or of a channel without a reader."""
    backend.world.ball = Ball(BALL)
    observation = backend.observe()
    signals.update(observation)
    regions, angles = [region(signals, name) for name in dexter.cameras], headings(signals)
    assert len(regions) == len(angles) == 2 and None not in regions
    channels, least = dexter.vision.channels, dexter.vision.regions.least_area
    ideal = {
        camera: ChannelFilter(channels, ["red", "sat_10"], least).regions(image)
        for camera, image in observation.images.items()
    }
    signals.reset()
    signals.update(replace(observation, images={}, regions=ideal))
    assert [region(signals, name) for name in dexter.cameras] == regions
    assert headings(signals) == angles
    tiny = {
        camera: {name: (each[0]._replace(area=least - 1),) for name, each in found.items()}
        for camera, found in ideal.items()
    }
    signals.reset()
    signals.update(replace(observation, images={}, regions=tiny))
    assert [region(signals, name) for name in dexter.cameras] == [None, None]
    assert signals.vision.images == 1


def test_each_heading_lingers_after_its_own_region(
    backend: SyntheticBackend, signals: Signals, dexter: RobotDocument
) -> None:
    """Red is seen at 0 s, green at 0.2 s, too; each is gone after a quarter of a second."""
    observation, moments = backend.observe(), Moments(4.0, 0.0, 4.0)
    red, green = (Region(60, column, 100.0, False, moments) for column in (60.0, 260.0))
    assert dexter.vision.regions.linger == 0.25
    kept = []
    for time, seen in (
        (0.0, {"red": (red,), "green": (green,)}),
        (0.2, {"green": (green,)}),
        (0.24, {}),
        (0.3, {}),
        (0.44, {}),
        (0.5, {}),
    ):
        signals.update(replace(observation, time=time, images={}, regions={"left": seen}))
        channels = ("red", "green")
        kept.append([signals.vision.heading("left", each) is not None for each in channels])
    both, one, none = [True, True], [False, True], [False, False]
    assert kept == [both, both, both, one, one, none]
