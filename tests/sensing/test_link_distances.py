"""Distances of links as signals: of an effector from another one, places, fixtures and objects."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import cbdsl
from cbdsl.api.load import load
from cbdsl.api.open_robot import open_robot
from cbdsl.api.requests.run_request import RunRequest
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.robot import HullSection, RobotDocument
from cbdsl.kinematics.link_clearance import LinkClearance, with_places
from cbdsl.kinematics.nearest_links import NearestLinks
from cbdsl.reporting.page import page
from cbdsl.reporting.recorded import read_recording
from cbdsl.robot.urdf import UrdfModel
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.runtime.recording import Recording
from cbdsl.runtime.tick import Tick
from cbdsl.types.resource import LinkDistance
from tests.reporting.test_page import header_of

NEAR = """cbdsl: 1
kind: program
name: near
robot: dexter
stage: {stage}
parameters: {{arm: left_arm}}
controllers:
  left: {{potential: spring, reference: [48 cm, {y} cm, {z} cm], feedback: $arm.position,
    effector: $arm}}
  back: {{potential: spring, reference: $arm.ready, feedback: $arm, effector: $arm}}
conditions: {{near: {condition}}}
steps:
  left: {{exits: [near: back], then: succeed}}
  back: {{then: fail since it was near}}
limits: {{episode_time: 8 s}}
"""


def near(
    folder: Path, condition: str, y: float = -15, z: float = 10, stage: str = "absent"
) -> RunRequest:
    path = folder / "near.yaml"
    path.write_text(NEAR.format(condition=condition, y=y, z=z, stage=stage), "utf-8")
    return load(path)


@pytest.fixture(scope="module")
def model(urdf: Path) -> UrdfModel:
    return read_urdf(urdf)


@pytest.mark.parametrize("other", ["", "right_arm", "right_hand", "arms", "head", "pole", "table"])
def test_distance_is_the_least_of_all_pairs_and_its_slope_the_mean_of_near_ones(
    dexter: RobotDocument, model: UrdfModel, other: str
) -> None:
    pole = HullSection(points=((0.4, 0.1, -0.5), (0.4, 0.1, 1.0)), radius=0.05)
    robot = with_places(dexter, {"pole": pole})
    hulls = {"table": HullSection(points=pole.points, radius=0.1)}
    source = LinkDistance("left_arm", other, (), is_fixture=other == "table")
    links = NearestLinks(robot, model, source, hulls)
    own, others = moved(robot, model, "left_arm"), moved(robot, model, other)
    every = LinkClearance(with_places(robot, hulls), model, 0.0, 100.0)

    def counts(one: str, two: str) -> bool:
        if {one, two} <= own & others:
            return False
        ends = ((one, two), (two, one))
        if other == "":
            return "table" not in (one, two) and (one in own or two in own)
        return any(a in own and (b in others or b == other) for a, b in ends)

    chosen = np.array([counts(*pair) for pair in every.names])
    rng = np.random.default_rng(3)
    for _ in range(20):
        posture = rng.uniform(-1.5, 1.5, len(every.joints))
        every.measure(posture)
        slope = links.measure(posture)
        least = max(float(every.arrays.pairs["distance"][chosen].min()), 0.0)
        assert links.distance == pytest.approx(least, abs=1e-9)
        if least > 0.005:
            step = 1e-6 * rng.normal(size=len(posture))
            before = every.arrays.pairs["distance"][chosen]
            weights = np.exp((least - before) / 0.005) * (before <= least + 0.025)
            every.measure(posture + step)
            change = every.arrays.pairs["distance"][chosen] - before
            mean = float(weights @ change / weights.sum())
            assert mean == pytest.approx(slope @ step, abs=1e-9)


GAP = """cbdsl: 1
kind: program
name: gap
robot: dexter
stage: absent
controllers:
  away: {{potential: at_least, reference: 5 cm, feedback: left_arm.clearance, effector: left_arm,
    gain: 8 /s, quiescence: {{rate: 1e-4, window: 0.3 s}}}}
  go: {{potential: spring, reference: [{x} m, {y} m, {z} m], feedback: left_arm.position,
    effector: left_arm}}
actions: [go, away, go ◁ away]
policy: {{XX: go ◁ away, "**": go ◁ away}}
limits: {{episode_time: 6 s}}
"""


@pytest.mark.parametrize("seed", [0, 1])
def test_level_on_a_distance_holds_both_of_two_obstacles_without_swinging(
    tmp_path: Path, seed: int
) -> None:
    """Send the hand into a gap of two poles that is too narrow for it."""
    rng, path = np.random.default_rng(seed), tmp_path / "gap.yaml"
    x, y, z = rng.uniform((0.48, 0.05, 0.0), (0.60, 0.35, 0.20))
    path.write_text(GAP.format(x=x, y=y, z=z), "utf-8")
    ends = [(x - 0.02, y + side, height) for side in (-0.05, 0.05) for height in (-0.6, 1.0)]
    poles = {
        f"pole_{k}": HullSection(points=(ends[2 * k], ends[2 * k + 1]), radius=0.02)
        for k in range(2)
    }
    request = load(path)
    request = replace(request, robot=with_places(request.robot, poles))
    with open_robot(request, backend="kinematic") as robot:
        told: list[float] = []
        robot.run(0, on_tick=lambda tick: told.extend(clear(tick)))
    # The nearest pair alone lets 3.3 and 0.7 cm, and swings over 1.7 and 1.4 cm in the last 1.5 s.
    assert min(told) > 0.04
    assert max(told[-30:]) - min(told[-30:]) < 0.006


def moved(robot: RobotDocument, model: UrdfModel, effector: str) -> set[str]:
    joints = set(robot.joints(effector)) if effector in robot.all_effectors else set[str]()
    return {link for link in model.links if any(j.name in joints for j in model.way(link))}


@pytest.mark.parametrize("backend", ["kinematic", "mujoco", "bullet"])
def test_condition_on_two_arms_ends_a_step_at_its_distance(tmp_path: Path, backend: str) -> None:
    request = near(tmp_path, "$arm.from.right_arm < 15 cm", y=-30)
    links = NearestLinks(
        request.robot, read_urdf(request.urdf), LinkDistance("left_arm", "right_arm", ())
    )
    told: list[tuple[str, float]] = []

    def note(tick: Tick) -> None:
        links.measure(tick.observation.positions)
        told.append((tick.run.state, links.distance))

    with open_robot(request, backend=backend) as robot:
        result = robot.run(0, on_tick=note)
    assert result.ending.endswith("since it was near.")
    values = {letter: [far for state, far in told if state == f"0X{letter}"] for letter in "01"}
    assert len(values["0"]) > 3 and min(values["0"]) >= 0.15
    assert values["1"] and max(values["1"]) < 0.15


def test_recording_and_page_name_the_nearest_links(tmp_path: Path) -> None:
    request = near(tmp_path, "$arm.clearance < 14 cm", y=-30)
    recording = Recording(request.program, request.robot, request.urdf)
    with open_robot(request, backend="kinematic") as robot:
        result = robot.run(0, on_tick=recording.note_tick)
    recorded = read_recording(recording.write(tmp_path / "recorded", result))
    pairs = recorded.summary["signals"]["left_arm.clearance"]["pairs"]
    numbers = recorded.arrays["pair_left_arm.clearance"].astype(int)
    shown = {pairs[number] for number in numbers}
    assert all(re.fullmatch(r"left_\w+ and \w+|\w+ and left_\w+", each) for each in shown)
    header = header_of(page(recorded))
    assert shown and header["pairs"] == {"left_arm.clearance": pairs}
    assert "pair_left_arm.clearance" in header["arrays"]


def test_distance_of_a_fixture_is_that_of_the_stage_of_the_run(tmp_path: Path) -> None:
    request = near(tmp_path, "$arm.from.table < 30 cm", z=-60, stage="table_right")
    with open_robot(request, backend="kinematic") as robot:
        assert robot.run(0).ending.endswith("since it was near.")
    with pytest.raises(UsageError, match="'table' is no fixture of stage 'held_right'"):
        load(tmp_path / "near.yaml", stage="held_right")


def test_distance_of_an_object_is_undefined_until_it_is_seen(tmp_path: Path) -> None:
    request = near(tmp_path, "$arm.from.stereo.green < 1 m")
    with open_robot(request, backend="kinematic") as robot:
        states: list[str] = []
        robot.run(0, on_tick=lambda tick: states.append(tick.run.state))
    assert {state[2] for state in states if state[0] == "0"} == {"-"}


def test_distance_of_a_seen_object_ends_a_step(tmp_path: Path) -> None:
    """Compare the distance of the palm's links from the seen ball with that of the true one."""
    path = tmp_path / "touch.yaml"
    path.write_text(
        """cbdsl: 1
kind: program
name: touch
robot: dexter
stage: table_right
use: {searchtrack: {program: searchtrack, with: {feature: sat_10}}}
controllers:
  reach: {potential: spring, reference: stereo.sat_10, feedback: right_arm.position,
    effector: right_arm}
conditions: {near: right_arm.from.stereo.sat_10 < 10 cm}
steps:
  searchtrack: {then: reach, failed: fail}
  reach: {exits: [near: succeed], then: fail}
limits: {episode_time: 12 s}
""",
        "utf-8",
    )
    with open_robot(load(path), backend="kinematic", cameras="ideal") as robot:
        last: list[float] = []
        result = robot.run(1, on_tick=lambda tick: last.extend(clear(tick)))
    assert result.outcome == "success", result.ending
    assert 0.05 < last[-1] < 0.10


def clear(tick: Tick) -> list[float]:
    distances = tick.signals.distances
    return [links.distance for links in distances._links.values() if links.pair]


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("shelf", "'shelf' is no fixture of stage 'absent'"),
        ("left_arm", "no link of 'left_arm' has a shape that can come near it"),
        ("stereo.red.velocity", "a distance is one from another effector"),
        ("right_arm.position", "a distance is one from another effector"),
        ("stereo.rad", "has no resource 'stereo.rad'"),
    ],
)
def test_distance_of_an_absent_body_is_one_finding(tmp_path: Path, name: str, says: str) -> None:
    path = tmp_path / "near.yaml"
    path.write_text(
        NEAR.format(condition=f"$arm.from.{name} < 10 cm", y=0, z=0, stage="absent"), "utf-8"
    )
    (finding,) = cbdsl.check(path)
    assert finding.code == "CB501" and says in finding.message


def test_distance_compared_with_a_force_is_one_finding(tmp_path: Path) -> None:
    path = tmp_path / "near.yaml"
    path.write_text(
        NEAR.format(condition="$arm.clearance < 3 N", y=0, z=0, stage="absent"), "utf-8"
    )
    (finding,) = cbdsl.check(path)
    assert finding.code == "CB658"
