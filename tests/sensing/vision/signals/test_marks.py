"""Marks are regions of another hue on an object, for every hue, without configuration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import cbdsl
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.instance_names import parse_mark
from cbdsl.robot.resources import resources
from cbdsl.sensing.channels import Moments, Region
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.vision.signals.marks import is_mark
from cbdsl.types.resource import Resource
from cbdsl.yaml_text.library import shipped

THING = "sat_10"


def region(column: float, row: float, radius: float, *, clipped: bool = False) -> Region:
    """Return a disk."""
    variance = radius * radius / 4
    area = round(np.pi * radius * radius)
    return Region(area, column, row, clipped, Moments(variance, 0.0, variance))


BALL = region(160, 120, 20)


@pytest.fixture
def signals(dexter: RobotDocument, kinematics: Kinematics) -> Signals:
    return Signals(dexter, kinematics, [resources(dexter)[f"mark.{THING}"]])


def look(signals: Signals, time: float, **seen: Region) -> np.ndarray | None:
    """Return the heading to the mark, after the same regions in both images."""
    signals.update(observation(signals, time, **seen))
    reading = signals.read(resources(signals.robot)[f"mark.{THING}"])
    return None if reading is None else reading.value


def test_jacobian_is_its_derivative_by_the_head(signals: Signals) -> None:
    """Marked points stand still while the cameras turn."""
    assert look(signals, 0.0, sat_10=BALL, blue=region(170, 125, 3)) is not None
    source = resources(signals.robot)[f"mark.{THING}"]
    here = signals.read(source)
    assert here is not None
    for column in signals.joints.of("head"):
        positions = np.zeros(len(signals.joints))
        positions[column] = 1e-6
        blind = replace(observation(signals, 0.01), positions=positions, regions={})
        signals.update(blind)
        there = signals.read(source)
        assert there is not None
        slope = (there.value - here.value) / 1e-6
        assert np.abs(slope).max() > 0.5
        assert here.jacobian[:, column] == pytest.approx(slope, abs=1e-4)


def observation(signals: Signals, time: float, **seen: Region) -> Observation:
    """Return an observation with the same regions in both images, and joints at 0."""
    positions = np.zeros(len(signals.joints))
    regions: Mapping[str, tuple[Region, ...]] = {name: (each,) for name, each in seen.items()}
    cells = signals.robot.load_cells.items()
    loads = {(hand, finger): np.zeros(6) for hand, fingers in cells for finger in fingers}
    both = dict.fromkeys(signals.robot.cameras, regions)
    return Observation(time, positions, np.zeros_like(positions), loads, {}, both)


@pytest.mark.parametrize(
    ("other", "is_one"),
    [
        (region(170, 120, 5), True),
        (region(160, 139, 5), True),  # at its edge
        (region(160, 160, 5), False),  # beside it
        (region(160, 120, 19), False),  # the thing in its own hue
        (region(162, 121, 200), False),  # the support of the object
        (region(170, 120, 5, clipped=True), False),
    ],
)
def test_mark_is_a_small_region_within_the_object(other: Region, is_one: bool) -> None:
    assert is_mark(other, BALL) == is_one


def test_long_object_has_marks_at_its_ends_and_none_beside() -> None:
    long = BALL._replace(moments=Moments(900.0, 0.0, 25.0))
    assert is_mark(region(215, 120, 3), long)
    assert not is_mark(region(160, 135, 3), long)


def test_largest_mark_is_selected_and_kept_while_seen(signals: Signals) -> None:
    small, large = region(150, 120, 3), region(168, 120, 6)
    assert look(signals, 0.0, sat_10=BALL, hue_2=BALL) is None
    first = look(signals, 0.1, sat_10=BALL, blue=small, green=region(166, 120, 5))
    assert first is not None and first[0] < 0  # to the right
    kept = look(signals, 0.2, sat_10=BALL, blue=region(150, 120, 9), green=large)
    assert kept is not None and kept[0] < 0
    other = look(signals, 0.3, sat_10=BALL, blue=small)
    assert other is not None and other[0] > 0


def test_mark_outlives_its_region_like_a_heading(signals: Signals) -> None:
    assert look(signals, 0.0, sat_10=BALL, blue=region(150, 120, 3)) is not None
    assert look(signals, 0.2, sat_10=BALL) is not None
    assert look(signals, 0.3, sat_10=BALL) is None


@pytest.mark.parametrize("colour", ["0, 0.4, 1", "0, 1, 0.2", "1, 0, 1"])
def test_mark_of_any_hue_is_brought_into_view(tmp_path: Path, colour: str) -> None:
    """Run VISUALINSPECT, whose TRACK has no hue."""
    stage = tmp_path / "spotted.yaml"
    spots = (shipped() / "programs" / "stages" / "spotted_right.yaml").read_text("utf-8")
    stage.write_text(
        spots.replace("name: spotted_right", "name: spotted").replace("0, 0.4, 1", colour), "utf-8"
    )
    request = cbdsl.load("visualinspect", stage=stage)
    (ended,) = cbdsl.run(request, backend="kinematic", seed=5000100, context="hidden")
    assert ended.rewarded


def test_hue_of_a_mark_may_be_named(dexter: RobotDocument, kinematics: Kinematics) -> None:
    blue = mark(dexter, f"mark.{THING}.blue")
    signals = Signals(dexter, kinematics, [blue])
    signals.update(observation(signals, 0.0, sat_10=BALL, green=region(150, 120, 6)))
    assert signals.read(blue) is None
    signals.update(
        observation(signals, 0.1, sat_10=BALL, green=region(150, 120, 6), blue=region(168, 120, 3))
    )
    reading = signals.read(blue)
    assert reading is not None and reading.value[0] < 0


def test_any_mark_has_one_name(dexter: RobotDocument) -> None:
    assert mark(dexter, "mark.red.any") == resources(dexter)["mark.red"]


def test_thing_has_no_mark_of_its_own_hue(dexter: RobotDocument) -> None:
    named = resources(dexter)
    for name in (
        "mark.red.red",
        "mark.red.hue_1",
        "mark.hue_1.red",
        "mark.red.sat_10",
        "mark.red.pink",
    ):
        parsed = parse_mark(name, named)
        assert parsed is not None and parsed.resource(name, dexter) is None
    assert parse_mark("mark.red", named) is None
    assert parse_mark("cyclopean.red.blue", named) is None


def test_every_hue_that_is_offered_names_a_mark(dexter: RobotDocument) -> None:
    for thing in ("red", THING):
        parsed = parse_mark(f"mark.{thing}.any", resources(dexter))
        assert parsed is not None and {"any", "blue", "hue_7"} < set(parsed.hues(dexter))
        for hue in parsed.hues(dexter):
            assert mark(dexter, f"mark.{thing}.{hue}").type.name == "heading"


def mark(robot: RobotDocument, name: str) -> Resource:
    parsed = parse_mark(name, resources(robot))
    resource = None if parsed is None else parsed.resource(name, robot)
    assert resource is not None
    return resource
