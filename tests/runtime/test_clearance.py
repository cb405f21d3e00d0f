"""A clearance keeps all links apart, above all actions, and says which pair it held."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest

import cbdsl
from cbdsl.api.load import load
from cbdsl.api.open_robot import open_robot
from cbdsl.api.requests.run_request import RunRequest
from cbdsl.diagnostics.errors import DiagnosticsError, UsageError
from cbdsl.documents.robot import ClearanceSection, HullSection, RobotDocument
from cbdsl.kinematics.link_clearance import LinkClearance, with_places
from cbdsl.numeric.arrays import Floats
from cbdsl.reporting.recorded import read_recording
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.runtime.recording import Recording
from cbdsl.runtime.tick import Tick
from tests.conftest import ROOT

LEAST = 0.02  # m
CROSSED = """cbdsl: 1
kind: program
name: cross
robot: dexter
stage: absent
controllers:
  left: {{potential: spring, reference: [{x} cm, -{y} cm, {z} cm], feedback: left_arm.position,
    effector: left_arm}}
  right: {{potential: spring, reference: [{x} cm, {y} cm, {z} cm], feedback: right_arm.position,
    effector: right_arm}}
actions: [left, right, left ◁ right]
policy: {{XX: left ◁ right, 0*: left ◁ right, 10: left ◁ right}}
success: ["11"]
guards: {{clearance: {clearance}}}
limits: {{episode_time: 8 s}}
"""


def crossed(
    folder: Path,
    clearance: str = "2 cm",
    given: str | None = None,
    x: float = 48,
    y: float = 15,
    z: float = 10,
) -> RunRequest:
    path = folder / "cross.yaml"
    path.write_text(CROSSED.format(x=x, y=y, z=z, clearance=clearance), "utf-8")
    return load(path, clearance=given)


@pytest.mark.parametrize("seed", range(3))
def test_clearance_of_crossed_hands_is_never_exceeded_in_a_tick(tmp_path: Path, seed: int) -> None:
    x, y, z = np.random.default_rng(seed).uniform((42, 12, 0), (58, 30, 20)).round(1)
    request, postures = crossed(tmp_path, x=x, y=y, z=z), list[Floats]()
    with open_robot(request, backend="kinematic") as robot:
        result = robot.run(0, on_tick=lambda tick: postures.append(tick.actuation.reference.copy()))
    links = LinkClearance(request.robot, read_urdf(request.urdf), LEAST)
    assert not [near for each in postures for near in links.nearer(each) if near.distance < 0.01999]
    # The right hand has priority, and pushes the left one out of its way.
    robot.kinematics.update(postures[-1])
    tip = request.robot.effectors["right_arm"].tip
    assert tip is not None
    place = robot.kinematics.point(tip.link, tip.offset).position
    assert 100 * place == pytest.approx([x, y, z], abs=2)
    assert "the clearance of 2 cm held" in result.ending
    assert any(guard.startswith("the clearance") for guard in result.guards)


def test_hand_that_another_link_holds_up_names_the_pair(tmp_path: Path) -> None:
    # The target is inside of the other hand, which stays where it is.
    with open_robot(crossed(tmp_path, y=0), backend="kinematic") as robot:
        result = robot.run(0)
    assert result.outcome == "failure"
    assert re.search(
        r"left is stuck, held by the clearance of left_\w+ from right_\w+ \(2.\d cm", result.ending
    )


def test_places_to_keep_out_of_hold_all_links_back(dexter: RobotDocument, tmp_path: Path) -> None:
    pole = HullSection(points=((0.45, 0.0, -0.5), (0.45, 0.0, 1.0)), radius=0.05)
    kept = ClearanceSection(distance=LEAST, keep_out={"pole": pole})
    request = crossed(tmp_path)
    robot = dexter.model_copy(update={"clearance": kept})
    request, postures = replace(request, robot=robot), list[Floats]()
    with open_robot(request, backend="kinematic") as opened:
        result = opened.run(
            0, on_tick=lambda tick: postures.append(tick.actuation.reference.copy())
        )
    links = LinkClearance(robot, read_urdf(request.urdf), LEAST)
    assert {name for pair in links.names for name in pair} >= {"pole", "right_palm"}
    near = [each for posture in postures for each in links.nearer(posture)]
    assert not [each for each in near if each.distance < 0.01999]
    assert "pole" in result.ending


def test_links_without_clearance_pass_through_each_other(tmp_path: Path) -> None:
    request, postures = crossed(tmp_path), list[Floats]()
    bare = request.program._replace(guards=request.program.guards._replace(clearance=None))
    request = replace(request, program=bare)
    with open_robot(request, backend="kinematic") as robot:
        robot.run(0, on_tick=lambda tick: postures.append(tick.actuation.reference.copy()))
    links = LinkClearance(request.robot, read_urdf(request.urdf), LEAST)
    assert min(near.distance for each in postures for near in links.nearer(each)) < 0.0


def test_clearance_beyond_the_start_posture_is_one_finding(tmp_path: Path) -> None:
    with pytest.raises(DiagnosticsError) as raised:
        crossed(tmp_path, "30 cm")
    (finding,) = raised.value.diagnostics
    assert finding.code == "CB587" and "the least is 30 cm" in finding.message


@pytest.mark.parametrize("given", ["2 N", "two", "-1 cm", "0 m", "nan"])
def test_clearance_that_is_no_length_is_refused(tmp_path: Path, given: str) -> None:
    with pytest.raises(UsageError, match="clearance: "):
        crossed(tmp_path, given=given)


def test_clearance_of_a_command_beyond_the_start_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="at the start"):
        crossed(tmp_path, given="30 cm")


def test_recording_names_the_pairs_that_were_held_for_longest(tmp_path: Path) -> None:
    request = crossed(tmp_path)
    recording = Recording(request.program, request.robot, request.urdf)
    with open_robot(request, backend="kinematic") as robot:
        result = robot.run(0, on_tick=recording.note_tick)
    recorded = read_recording(recording.write(tmp_path / "recorded", result))
    guards, held = recorded.summary["guards"], recorded.arrays["guard_held"]
    assert held.shape == (recording.ticks, len(guards))
    assert 0 < len(guards) <= 6
    assert all(" near " in name for name in guards)
    assert held.any(axis=0).all()


AVOIDING = """cbdsl: 1
kind: program
name: avoid
robot: dexter
stage: table_right
use: {{searchtrack: {{program: searchtrack, with: {{feature: sat_10}}}}}}
controllers:
  reach: {{potential: spring, reference: {goal}, feedback: right_arm.position, effector: right_arm}}
actions: [searchtrack, reach]
steps:
  look: {{do: searchtrack, then: reach, failed: fail}}
  reach: {{do: reach, then: succeed}}
guards: {{clearance: 2 cm, avoid: [{avoid}]}}
limits: {{episode_time: 12 s}}
"""


def avoiding(folder: Path, goal: str, avoid: str) -> RunRequest:
    path = folder / "avoid.yaml"
    path.write_text(AVOIDING.format(goal=goal, avoid=avoid), "utf-8")
    return load(path)


def test_fixture_to_avoid_holds_all_links_back(tmp_path: Path) -> None:
    request, postures = avoiding(tmp_path, "[45 cm, -25 cm, -50 cm]", "table"), list[Floats]()
    with open_robot(request, backend="kinematic") as robot:
        result = robot.run(1, on_tick=lambda tick: postures.append(tick.actuation.reference.copy()))
    table = request.stage.fixtures["table"]
    corners = product(
        *((x[0] - h, x[0] + h) for x, h in zip(table.position, (0.3, 0.6, 0.02), strict=True))
    )
    links = LinkClearance(
        with_places(request.robot, {"table": HullSection(points=tuple(corners))}),
        read_urdf(request.urdf), LEAST,
    )  # fmt: skip
    assert not [near for each in postures for near in links.nearer(each) if near.distance < 0.01999]
    assert "from table" in result.ending and "the clearance of 2 cm held" in result.ending


def test_clearance_of_a_command_that_a_fixture_breaks_at_the_start_is_refused(
    tmp_path: Path,
) -> None:
    avoiding(tmp_path, "stereo.sat_10", "table")
    stage = (ROOT / "programs" / "stages" / "table_right.yaml").read_text("utf-8")
    high = stage.replace("0 cm, -44 cm]", "0 cm, -28 cm]")
    (tmp_path / "high.yaml").write_text(high, "utf-8")
    load(tmp_path / "avoid.yaml", stage=tmp_path / "high.yaml", clearance="14 cm")
    with pytest.raises(UsageError, match=r"clearance 16 cm: at the start .* from table"):
        load(tmp_path / "avoid.yaml", stage=tmp_path / "high.yaml", clearance="16 cm")


def test_seen_object_to_avoid_holds_all_links_back(tmp_path: Path) -> None:
    """Send the palm into the ball, whose place the links know from the cameras alone."""
    request, apart = avoiding(tmp_path, "stereo.sat_10", "stereo.sat_10"), list[float]()
    with open_robot(request, backend="kinematic", cameras="ideal") as robot:

        def note(tick: Tick) -> None:
            pairs = tick.actuation.clearance.arrays.pairs
            apart.append(float(pairs["distance"][pairs["near"]].min(initial=1.0)))

        result = robot.run(1, on_tick=note)
    assert 0.015 < min(apart) < 0.03, "the palm came to the ball, and no nearer"
    assert "from stereo.sat_10" in result.ending


@pytest.mark.parametrize(
    ("avoid", "says"),
    [
        ("shelf", "'shelf' is no fixture of stage 'table_right' (known: table)"),
        ("right_arm.position", "'right_arm.position' is no position of a seen object"),
    ],
)
def test_object_to_avoid_that_is_not_known_is_one_finding(
    tmp_path: Path, avoid: str, says: str
) -> None:
    path = tmp_path / "avoid.yaml"
    path.write_text(AVOIDING.format(goal="stereo.sat_10", avoid=avoid), "utf-8")
    (finding,) = cbdsl.check(path)
    assert finding.code == "CB587" and says in finding.message


def test_fixture_to_avoid_that_a_stage_lacks_is_refused(tmp_path: Path) -> None:
    avoiding(tmp_path, "stereo.sat_10", "table")
    with pytest.raises(UsageError, match="no fixture of stage 'held_right'"):
        load(tmp_path / "avoid.yaml", stage="held_right")


def test_objects_to_avoid_without_a_distance_are_one_finding(tmp_path: Path) -> None:
    text = AVOIDING.format(goal="stereo.sat_10", avoid="table").replace("clearance: 2 cm, ", "")
    (tmp_path / "avoid.yaml").write_text(text, "utf-8")
    with pytest.raises(DiagnosticsError, match="'avoid' needs the distance"):
        load(tmp_path / "avoid.yaml")


def test_objects_to_avoid_may_be_parameters(tmp_path: Path) -> None:
    text = AVOIDING.format(goal="stereo.sat_10", avoid="$target, $fixture")
    given = "parameters: {target: stereo.sat_10, fixture: table}\nuse:"
    (tmp_path / "avoid.yaml").write_text(text.replace("use:", given), "utf-8")
    guards = load(tmp_path / "avoid.yaml").program.guards
    assert [each.name for each in guards.seen] == ["stereo.sat_10"]
    assert list(guards.hulls) == ["table"]
