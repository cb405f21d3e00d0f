"""Novel regions are those at which the background model of their channel expects nothing."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.sensing.channels import Moments, Region
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.vision.regions.camera import direction, heading
from cbdsl.sensing.vision.signals.novelty import centring
from cbdsl.types.resource import KernelSample, NovelHeading, Origin, Resource
from cbdsl.types.resource_type import HEADING

CAMERA, STEP = "left_camera", 1e-6
HERE, SPREAD = (0.3, 0.6), 0.05


def posture(signals: Signals, head: tuple[float, ...]) -> np.ndarray:
    positions = np.zeros(len(signals.joints))
    positions[signals.joints.of("head")] = head
    return positions


def observe(
    signals: Signals, head: tuple[float, ...], regions: list[Region] | None, time: float
) -> None:
    """Observe a tick with the same regions in both images, or without images."""
    observe_both(signals, head, regions, regions, time)


def observe_both(
    signals: Signals,
    head: tuple[float, ...],
    left: list[Region] | None,
    right: list[Region] | None,
    time: float,
) -> None:
    """Observe a tick with regions in each image, or without that image."""
    positions, both = posture(signals, head), {"left": left, "right": right}
    seen = {name: {"hue_7": tuple(own)} for name, own in both.items() if own is not None}
    cells = signals.robot.load_cells.items()
    loads = {(hand, finger): np.zeros(6) for hand, fingers in cells for finger in fingers}
    signals.update(Observation(time, positions, np.zeros_like(positions), loads, {}, seen))


def region(column: float = 160.0, area: int = 200, *, clipped: bool = False) -> Region:
    return Region(area, column, 120.0, clipped, Moments(4.0, 4.0, 0.0))


@pytest.fixture
def novel() -> Resource:
    source = NovelHeading("hue_7", "head", KernelSample("head", (HERE,), (SPREAD, SPREAD)))
    return Resource("novel.hue_7", HEADING, Origin.ENVIRONMENT, source)


@pytest.fixture
def signals(dexter: RobotDocument, kinematics: Kinematics, novel: Resource) -> Signals:
    return Signals(dexter, kinematics, [novel])


def test_turns_bring_a_line_of_sight_to_the_middle(signals: Signals) -> None:
    """Panning turns the image, instead of shifting it, the more the head is lowered."""
    for tilt in (-0.3, 0.2, 1.0):
        here = np.array((0.4, tilt))
        observe(signals, tuple(here), [], 0.0)
        line = direction(np.array((0.3, -0.2)))
        seen = signals.kinematics.frame(CAMERA).rotation @ line
        columns = signals.joints.of("head")
        turns = centring(signals.kinematics.own_turning(CAMERA)[:, columns], line)
        observe(signals, tuple(here + turns), [], 0.0)
        rotation = signals.kinematics.frame(CAMERA).rotation
        assert heading(rotation.T @ seen) == pytest.approx([0.0, 0.0], abs=1e-6)


def test_background_is_not_novel_from_any_view(signals: Signals, novel: Resource) -> None:
    """Observe the same direction, in the middle of the image and at its left."""
    observe(signals, HERE, [region()], 0.0)
    assert signals.read(novel) is None
    pan = 0.2
    column = 160.0 + 418.5 * np.tan(pan) * np.cos(HERE[1])
    observe(signals, (HERE[0] + pan, HERE[1]), [region(column)], 1.0)
    assert signals.read(novel) is None
    observe(signals, (HERE[0] + pan, HERE[1]), [region(320 - column)], 2.0)
    assert signals.read(novel) is not None


def test_largest_novel_region_off_the_border_is_selected(signals: Signals, novel: Resource) -> None:
    expected, other = region(area=900), region(40.0, area=300)
    observe(signals, HERE, [expected, region(310.0, 500, clipped=True), other], 0.0)
    reading = signals.read(novel)
    assert reading is not None
    assert reading.value[0] == pytest.approx(np.arctan2(120.0, 418.5), abs=1e-9)


def test_novel_heading_moves_with_the_head(signals: Signals, novel: Resource) -> None:
    observe(signals, HERE, [region(40.0)], 0.0)
    here = signals.read(novel)
    assert here is not None and here.jacobian is not None
    for place, column in enumerate(signals.joints.of("head")):
        head = tuple(np.array(HERE) + STEP * np.eye(2)[place])
        observe(signals, head, None, 0.0)
        there = signals.read(novel)
        assert there is not None
        slope = (there.value - here.value) / STEP
        assert here.jacobian[:, column] == pytest.approx(slope, abs=1e-4)


def test_novel_region_lingers(signals: Signals, novel: Resource) -> None:
    linger = signals.robot.vision.regions.linger
    observe(signals, HERE, [region(40.0)], 0.0)
    observe(signals, HERE, [], 0.9 * linger)
    assert signals.read(novel) is not None
    observe(signals, HERE, [], 1.1 * linger)
    assert signals.read(novel) is None


def test_both_cameras_select_the_same_novel_object(signals: Signals, novel: Resource) -> None:
    """Choose the first camera's larger object if each camera sees another one larger."""
    one, other = (region(column, area=300) for column in (40.0, 280.0))
    smaller = [each._replace(area=200) for each in (one, other)]
    observe_both(signals, HERE, [one, smaller[1]], [other, smaller[0]], 0.0)
    reading = signals.read(novel)
    assert reading is not None
    assert reading.value[0] == pytest.approx(np.arctan2(120.0, 418.5), abs=1e-9)
    observe_both(signals, HERE, [region()], [other, smaller[0]], 1.0)
    reading = signals.read(novel)
    assert reading is not None
    assert reading.value[0] == pytest.approx(-np.arctan2(120.0, 418.5), abs=1e-9)
