"""Constellations of two blobs, and the controllers that watch them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.control.potentials.spring import spring
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.pair_names import pair_resource, parse_pair
from cbdsl.robot.resources import resources
from cbdsl.sensing.vision.signals.blob_signals import (
    Blob,
    Constellation,
    constellation_of,
    half_turn,
)
from cbdsl.types.resource import ConstellationSignal, StereoOffset


def blob(longer: float, shorter: float, orientation: float | None) -> Blob:
    return Blob(np.array([longer, shorter]), orientation)


def test_constellation_holds_relative_scales_and_the_angle() -> None:
    own = constellation_of(blob(0.06, 0.02, 1.0), blob(0.03, 0.02, 0.3))
    assert own.value == pytest.approx([2.0, 1.0, 0.7])


@given(turn=st.floats(-1.5, 1.5), other=st.floats(-1.5, 1.5))
def test_rolled_camera_and_a_distance_change_nothing(turn: float, other: float) -> None:
    before = constellation_of(blob(0.06, 0.02, 0.4), blob(0.03, 0.01, -0.2))
    after = constellation_of(
        blob(0.03, 0.01, half_turn(0.4 + turn)), blob(0.015, 0.005, half_turn(-0.2 + turn))
    )
    assert after.value == pytest.approx(before.value, abs=1e-9)
    assert half_turn(other) == pytest.approx(other)


def test_round_blob_turns_by_nothing() -> None:
    assert constellation_of(blob(0.03, 0.03, None), blob(0.05, 0.02, 1.2)).turn == 0.0


def test_axis_is_the_same_after_half_a_turn() -> None:
    near, far = Constellation(1.0, 1.0, 1.55), Constellation(1.0, 1.0, -1.55)
    potential = spring("constellation", 3)
    phi, residual, _ = potential.evaluate(near.value, far.value, 3)
    assert residual[2] == pytest.approx(math.pi - 3.1)
    assert phi == pytest.approx(0.5 * (math.pi - 3.1) ** 2)


def test_names_of_two_channels_are_signals_of_both(dexter: RobotDocument) -> None:
    known = resources(dexter)
    seen, apart = (pair_resource(f"{of}.red.to.blue", known) for of in ("left", "stereo"))
    assert seen is not None and seen.source == ConstellationSignal("left", "red", "blue")
    assert apart is not None and apart.source == StereoOffset("red", "blue")
    assert (seen.type.size, apart.type.size, apart.type.unit) == (3, 3, "m")


@pytest.mark.parametrize(
    "name", ["left.red.to.bleu", "cyclopean.red.to.blue", "left.red.on.blue", "count.red.to.blue"]
)
def test_names_without_two_channels_are_no_pair(name: str, dexter: RobotDocument) -> None:
    assert parse_pair(name, resources(dexter)) is None


def test_channel_is_not_compared_with_itself_by_another_name(dexter: RobotDocument) -> None:
    channels = dexter.vision.channels.model_copy(update={"aliases": {"crimson": "red"}})
    vision = dexter.vision.model_copy(update={"channels": channels})
    robot = dexter.model_copy(update={"vision": vision})
    assert pair_resource("left.red.to.crimson", resources(robot)) is None
