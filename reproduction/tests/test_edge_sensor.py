"""Sensor of a hand at seen things: lines to close across, parts of a held thing, and looks."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from test_robosuite_judge import write_with_edges

from cbdsl.extend.backend import read_robot
from cbdsl.extend.source import Reading, SensorSignal, Signals
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl_reproduction.worlds.box_fit import Floats
from cbdsl_reproduction.worlds.edge_sensor import EDGES, reader

HAND = "hand"
PLACES = {"red": np.array([0.45, 0.1, 0.2]), "blue": np.array([0.4, 0.14, 0.22])}
POSTURE = np.array([0.1, 0.3, -0.2, -2.0, 0.1, 2.3, 0.6, 0.04])


@pytest.fixture
def signals(tmp_path: Path) -> Signals:
    """Return the signals of a Panda that sees a red and a blue thing."""
    write_with_edges("panda", tmp_path)
    robot, urdf = read_robot(tmp_path / "robots" / "seeing.yaml")
    made = Signals(robot, Kinematics(robot, urdf), ())
    made.vision.memory = lambda channel: SimpleNamespace(position=PLACES[channel])  # type: ignore
    made.vision.images = 1
    move(made, POSTURE)
    return made


def move(signals: Signals, posture: Floats) -> None:
    signals.kinematics.update(posture)


def read(signals: Signals, part: str) -> Reading:
    (name,) = signals.robot.sensors
    reading = reader(SensorSignal(name, EDGES.name, part, ()), signals)()
    assert reading is not None
    return reading


def closing(signals: Signals, rotation: Floats) -> Floats:
    """Return the direction in which fingers close at an orientation of the tip, shape (3,)."""
    first, second = signals.robot.load_cells[HAND].values()
    pads = [signals.kinematics.frame(cell.link).position for cell in (first, second)]
    way = rotation @ signals.tips.frame("arm").rotation.T @ (pads[1] - pads[0])
    return np.asarray(way / np.linalg.norm(way))


def test_fingers_close_across_the_line_between_two_things(signals: Signals) -> None:
    rotation = read(signals, "red_blue").value
    np.testing.assert_allclose(rotation[:, 2], [0.0, 0.0, -1.0], atol=1e-9)
    line = (PLACES["blue"] - PLACES["red"])[:2]
    assert closing(signals, rotation)[:2] @ line == pytest.approx(0.0, abs=1e-6)


def test_line_is_undefined_before_both_things_are_seen(signals: Signals) -> None:
    seen = {"red": PLACES["red"], "blue": None}
    signals.vision.memory = lambda channel: SimpleNamespace(position=seen[channel])  # type: ignore
    (name,) = signals.robot.sensors
    assert reader(SensorSignal(name, EDGES.name, "red_blue", ()), signals)() is None


@pytest.mark.parametrize(
    ("part", "way"), [("to_left", [0, 1, 0]), ("to_right", [0, -1, 0]), ("down", [0, 0, -1])]
)
def test_hand_looks_along_an_axis_and_closes_along_x(
    signals: Signals, part: str, way: list[int]
) -> None:
    rotation = read(signals, part).value
    np.testing.assert_allclose(rotation[:, 2], way, atol=1e-9)
    np.testing.assert_allclose(rotation.T @ rotation, np.eye(3), atol=1e-9)
    assert abs(closing(signals, rotation)[0]) == pytest.approx(1.0, abs=1e-6)


def test_part_of_a_held_thing_moves_with_the_hand(signals: Signals) -> None:
    (name,) = signals.robot.sensors
    held = reader(SensorSignal(name, EDGES.name, "held_blue", ()), signals)
    before, tip = held(), signals.tips.frame("arm")
    assert before is not None
    np.testing.assert_allclose(before.value, PLACES["blue"])
    own = tip.rotation.T @ (PLACES["blue"] - tip.position)
    signals.touch.feeling[:] = True
    for joint in range(7):
        nudge = 1e-6 * np.eye(8)[joint]
        move(signals, POSTURE + nudge)
        after, tip = held(), signals.tips.frame("arm")
        assert after is not None and before.jacobian is not None
        np.testing.assert_allclose(after.value, tip.position + tip.rotation @ own, atol=1e-9)
        slope = (after.value - before.value) / 1e-6
        np.testing.assert_allclose(slope, before.jacobian[:, joint], atol=1e-5)


def test_far_part_of_a_bar_is_opposite_to_the_thing_at_its_end(signals: Signals) -> None:
    way = PLACES["red"] - PLACES["blue"]
    place = read(signals, "beyond_red_blue").value
    np.testing.assert_allclose(np.cross(place - PLACES["red"], way), 0.0, atol=1e-9)
    assert 0.0 < (place - PLACES["red"]) @ way < way @ way


@pytest.mark.parametrize("wrist", [-2.7, 0.6, 2.7])
def test_turn_to_a_part_ahead_keeps_to_the_limits_of_the_wrist(
    signals: Signals, wrist: float
) -> None:
    posture = POSTURE.copy()
    posture[6] = wrist
    move(signals, posture)
    rotation, tip = read(signals, "ahead_blue").value, signals.tips.frame("arm")
    now = closing(signals, tip.rotation)
    then = closing(signals, rotation)
    turn = np.arctan2(now[0] * then[1] - now[1] * then[0], now[:2] @ then[:2])
    # The hand looks down, so that its last joint turns against the heading.
    assert signals.kinematics.lower[6] < wrist - turn < signals.kinematics.upper[6]
