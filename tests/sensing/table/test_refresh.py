"""Rows that are compiled: their values by the links' frames, their Jacobians by differences."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.kinematics.rotation import log
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.resources import resources
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.table.reading import Reading
from cbdsl.types.resource import (
    Centroid,
    EffectorConfiguration,
    FingerForces,
    Separation,
    Tip,
)
from cbdsl.yaml_text.library import Library, shipped

LIBRARY = Library(shipped())
STEP = 1e-6
RADIUS, STANDOFF = 0.05, (0.03, 0.02, 0.2)


class Case(NamedTuple):
    """Row of a resource, or of a controller's function of it."""

    robot: str
    kind: str
    of: str


@cache
def document(robot: str) -> RobotDocument:
    return LIBRARY.read(LIBRARY.locate(RobotDocument, robot), RobotDocument).document


def kinematics(robot: str) -> Kinematics:
    path = LIBRARY.locate(RobotDocument, robot)
    return Kinematics(document(robot), path.parent / document(robot).model)


def cases() -> Iterator[Case]:
    for name in LIBRARY.names(RobotDocument):
        robot, named = document(name), resources(document(name))
        tips = [effector for effector, each in robot.effectors.items() if each.tip is not None]
        for resource in named.values():
            if isinstance(resource.source, (Tip, Centroid, Separation, EffectorConfiguration)):
                yield Case(name, "resource", resource.name)
            if isinstance(resource.source, FingerForces):
                yield Case(name, "normal forces", resource.name)
        groups = [group for group in robot.groups if set(robot.members(group)) <= set(tips)]
        for effector in (*tips, *groups):
            yield Case(name, "position manipulator", effector)
            yield Case(name, "pose manipulator", effector)
        for effector in tips:
            yield Case(name, "standoff", effector)


def bind(case: Case, signals: Signals) -> int:
    robot, named = document(case.robot), resources(document(case.robot))
    if case.kind == "resource":
        return signals.bind(named[case.of])
    if case.kind == "normal forces":
        source = named[case.of].source
        assert isinstance(source, FingerForces)
        return signals.bind_normal_forces(source)
    if case.kind == "standoff":
        seen = signals.bind_written(3)
        signals.table.write(seen, Reading(np.zeros(3), None, 0, RADIUS))
        return signals.kinematic_rows.tip_off(Tip(case.of, "position"), seen, STANDOFF)
    return signals.kinematic_rows.manipulator(case.of, case.kind.split()[0], robot.joints(case.of))


def expected(case: Case, model: Kinematics, loads: Floats) -> Floats:
    """Return the value of a row by the frames and Jacobians of links."""
    robot = document(case.robot)
    if case.kind == "normal forces":
        return normal_forces(case, model, loads)
    if case.kind == "standoff":
        along = model.frame(tip_of(robot, case.of)[0]).rotation[:, 2]
        return position(robot, model, case.of) + (RADIUS + STANDOFF[0]) * along
    if case.kind != "resource":
        rows = 6 if case.kind.startswith("pose") else 3
        own = model.joints.pick(robot.joints(case.of))
        tips = [model.point(*tip_of(robot, each)).jacobian for each in robot.members(case.of)]
        return np.vstack([tip[:rows, own] for tip in tips]).ravel()
    return resource_value(case, model)


def resource_value(case: Case, model: Kinematics) -> Floats:
    robot = document(case.robot)
    source = resources(robot)[case.of].source
    if isinstance(source, EffectorConfiguration):
        return model.positions[model.joints.of(source.effector)]
    if isinstance(source, Centroid):
        return np.mean([position(robot, model, arm) for arm in robot.members(source.group)], axis=0)
    if isinstance(source, Separation):
        first, second = (position(robot, model, arm) for arm in robot.members(source.group))
        return second - first
    assert isinstance(source, Tip)
    members = robot.members(source.effector)
    places = [position(robot, model, arm) for arm in members]
    if source.part == "position":
        return np.concatenate(places)
    turned = model.frame(tip_of(robot, source.effector)[0]).rotation.ravel()
    return turned if source.part == "orientation" else np.concatenate((*places, turned))


def normal_forces(case: Case, model: Kinematics, loads: Floats) -> Floats:
    robot = document(case.robot)
    source = resources(robot)[case.of].source
    assert isinstance(source, FingerForces)
    first = list(robot.load_cells).index(source.hand) * len(robot.load_cells[source.hand])
    cells = [*robot.load_cells[source.hand].values()]
    normals = [
        model.frame(cell.link).rotation @ np.array(cell.normal) / np.linalg.norm(cell.normal)
        for cell in cells
    ]
    felt = np.array([n @ loads[first + i, :3] for i, n in enumerate(normals)])
    # One joint cannot change the difference of the fingers that it flexes equally.
    drives = [(cell.joint, cell.share) for cell in cells]
    return np.array([felt[[other == own for other in drives]].mean() for own in drives])


def tip_of(robot: RobotDocument, effector: str) -> tuple[str, tuple[float, float, float]]:
    tip = robot.effectors[effector].tip
    assert tip is not None
    return tip.link, tip.offset


def position(robot: RobotDocument, model: Kinematics, effector: str) -> Floats:
    link, offset = tip_of(robot, effector)
    frame = model.frame(link)
    return frame.position + frame.rotation @ np.array(offset)


def difference(case: Case, ahead: Floats, behind: Floats) -> Floats:
    """Return the difference in the Jacobian's components: rotations by a rotation vector."""
    kind = resources(document(case.robot))[case.of].type.name if case.kind == "resource" else ""
    if kind not in ("orientation", "pose"):
        return ahead - behind
    turn = log(ahead[-9:].reshape(3, 3) @ behind[-9:].reshape(3, 3).T)
    return np.concatenate((ahead[:-9] - behind[:-9], turn))


CASES = list(cases())


@pytest.mark.parametrize("case", CASES, ids="-".join)
def test_values_are_those_of_the_links_and_jacobians_their_differences(case: Case) -> None:
    rng, robot = np.random.default_rng(2), document(case.robot)
    oracle = kinematics(case.robot)
    signals = Signals(robot, kinematics(case.robot), ())
    row = bind(case, signals)
    signals.touch.loads[:] = rng.normal(size=signals.touch.loads.shape)
    signals.touch.feeling[:] = True
    for q in rng.uniform(oracle.lower, oracle.upper, (3, len(oracle.lower))):
        here, jacobian = read(signals, row, q)
        oracle.update(q)
        wanted = expected(case, oracle, signals.touch.loads)
        np.testing.assert_allclose(here, wanted, rtol=0, atol=1e-12)
        if case.kind == "normal forces":
            # By the joints that flex the fingers, whose links' turning changes it as well.
            assert (np.count_nonzero(jacobian, axis=1) == 1).all()
            control, slides = robot.control, kinematics(case.robot).slides
            moved = slides[np.argmax(np.abs(jacobian), axis=1)]
            stiffness = np.where(moved, control.slide_stiffness, control.stiffness)
            np.testing.assert_array_equal(np.abs(jacobian).max(axis=1), stiffness)
            continue
        slopes = [
            difference(case, read(signals, row, q + change)[0], read(signals, row, q - change)[0])
            for change in STEP * np.eye(len(q))
        ]
        np.testing.assert_allclose(jacobian, np.array(slopes).T / (2 * STEP), atol=1e-7)


def read(signals: Signals, row: int, q: Floats) -> tuple[Floats, Floats]:
    signals.kinematics.update(q)
    found = signals.reading(row)
    assert found is not None and found.jacobian is not None
    return found.value, found.jacobian


def test_every_robot_has_rows_of_its_own() -> None:
    assert {case.robot for case in CASES} == set(LIBRARY.names(RobotDocument))
    of_dexter = {case.kind for case in CASES if case.robot == "dexter"}
    assert of_dexter == {
        "resource", "normal forces", "position manipulator", "pose manipulator", "standoff",
    }  # fmt: skip


def test_forces_along_normals_are_measured_only_while_all_fingers_feel(
    dexter: RobotDocument, kinematics: Kinematics
) -> None:
    signals, source = Signals(dexter, kinematics, ()), FingerForces("right_hand")
    row = signals.bind_normal_forces(source)
    cells = [(hand, finger) for hand, own in dexter.load_cells.items() for finger in own]
    still = np.zeros(len(kinematics.lower))
    loads = {cell: np.zeros(6) for cell in cells}
    signals.update(Observation(0.0, still, still, loads, {}))
    for cell in [each for each in cells if each[0] == "right_hand"]:
        assert signals.reading(row) is None
        loads[cell] = np.r_[2.0, 0.0, 0.0, np.zeros(3)]
        signals.update(Observation(0.0, still, still, loads, {}))
    assert signals.reading(row) is not None
