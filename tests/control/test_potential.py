"""Gradients of all potentials by the joints of every robot that has a document."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

from cbdsl.control.potential_registry import build
from cbdsl.control.setting import Setting
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Frame, Kinematics
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.resources import resources
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.vision.regions.camera import heading, sighting_jacobian
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.resource_type import HEADING, TYPES, ResourceType, configuration
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT
from tests.control.evaluation import Signal, evaluate, gradient
from tests.control.test_potential_registry import controller

LIBRARY = Library(ROOT)
ROBOTS = {
    name: LIBRARY.read(LIBRARY.locate(RobotDocument, name), RobotDocument).document
    for name in LIBRARY.names(RobotDocument)
}
SMALL = 1e-6


class Case(NamedTuple):
    """Measured signal: a part of an effector or a group, or a sighting."""

    robot: str
    potential: str
    effector: str
    part: str


@cache
def signals(robot: str) -> Signals:
    document = ROBOTS[robot]
    return Signals(document, Kinematics(document, ROOT / "robots" / document.model), ())


def kinematics(robot: str) -> Kinematics:
    return signals(robot).kinematics


def cases() -> list[Case]:
    found = []
    for name, robot in ROBOTS.items():
        for effector in (*robot.effectors, *robot.groups):
            found += [Case(name, "spring", effector, "configuration")]
            found += [Case(name, "range", effector, "configuration")]
            if all(robot.effectors[member].tip for member in robot.members(effector)):
                found += tips(name, effector)
    return found


def tips(name: str, effector: str) -> list[Case]:
    robot, found = ROBOTS[name], []
    members = len(robot.members(effector))
    if members == 1:
        found += [Case(name, "spring", effector, part) for part in ("orientation", "pose")]
        found += [Case(name, "look_at", effector, "pose")]
    else:
        found += [Case(name, "spring", effector, "position")]
    found += [Case(name, bound, effector, "position") for bound in ("at_most", "at_least")]
    for part, rows in (("position", 3), ("pose", 6)):
        if rows * members <= len(robot.joints(effector)):
            found += [Case(name, "manipulability", effector, part)]
    if len(robot.cameras) == 2:
        found += [Case(name, "localizability", effector, part) for part in ("held", "seen")]
    return found


CASES = cases()


def measure(case: Case, q: Floats, anchor: Floats) -> Signal:
    model, robot = kinematics(case.robot), ROBOTS[case.robot]
    model.update(q)
    if case.potential == "localizability":
        return sighting(case, anchor)
    table = signals(case.robot)
    if case.potential == "manipulability":
        row = table.kinematic_rows.manipulator(
            case.effector, case.part, robot.joints(case.effector)
        )
        found = table.reading(row)
    else:
        name = case.effector
        if case.part != "configuration":
            name = f"{name}.{case.part}"
        found = table.read(resources(robot)[name])
    assert found is not None
    assert found.jacobian is not None
    return Signal(found.value, found.jacobian)


def carried(case: Case) -> Signal:
    """Return the signal of an object that an effector or a group would carry."""
    tips, share = signals(case.robot).tips, float(case.part == "held")
    points = [tips.point(arm) for arm in ROBOTS[case.robot].members(case.effector)]
    return Signal(
        share * np.mean([point.position for point in points], axis=0),
        share * np.mean([point.jacobian[:3] for point in points], axis=0),
    )


def cameras(case: Case) -> list[Frame]:
    model = kinematics(case.robot)
    return [model.frame(camera.link) for camera in ROBOTS[case.robot].cameras.values()]


def sighting(case: Case, anchor: Floats) -> Signal:
    """Return the headings to a point at ``anchor`` from its carrier."""
    carrier, values, rows = carried(case), [], []
    for frame, camera in zip(cameras(case), ROBOTS[case.robot].cameras.values(), strict=True):
        moves = kinematics(case.robot).jacobian(camera.link)
        sight = carrier.value + anchor - frame.position
        passing = carrier.jacobian - moves[:3] - np.cross(moves[3:].T, sight).T
        values.append(heading(frame.rotation.T @ sight))
        rows.append(sighting_jacobian(frame.rotation.T @ sight) @ frame.rotation.T @ passing)
    return Signal(np.concatenate(values), np.vstack(rows))


def ahead(case: Case, q: Floats, rng: np.random.Generator) -> Floats:
    """Return the anchor of a point in front of the cameras in a posture."""
    kinematics(case.robot).update(q)
    if case.potential != "localizability":
        return np.zeros(3)
    frame = cameras(case)[0]
    point = frame.position + frame.rotation @ rng.uniform([0.4, -0.2, -0.2], [0.9, 0.2, 0.2])
    return point - carried(case).value


def feedback(case: Case) -> ResourceType:
    robot = ROBOTS[case.robot]
    if case.potential == "localizability":
        return HEADING.times(2)
    if case.part == "configuration" or case.potential == "manipulability":
        return configuration(len(robot.joints(case.effector)))
    return TYPES[case.part].times(len(robot.members(case.effector)))


def setting(case: Case) -> Setting:
    model, robot = kinematics(case.robot), ROBOTS[case.robot]
    own = model.joints.of(case.effector)
    frames = cameras(case)
    relative = [
        Frame(
            frames[0].rotation.T @ (frame.position - frames[0].position),
            frames[0].rotation.T @ frame.rotation,
        )
        for frame in frames
    ]
    rows = {"position": 3, "pose": 6}.get(case.part, 0)
    components = rows * len(robot.members(case.effector)) * len(robot.joints(case.effector))
    return Setting(model.lower[own], model.upper[own], components, components, tuple(relative))


@pytest.mark.parametrize("case", CASES, ids=lambda case: "-".join(case))
def test_gradient_equals_finite_differences(case: Case, rng: np.random.Generator) -> None:
    model = kinematics(case.robot)
    law = build(controller(case.potential, feedback(case)), setting(case))
    for q, goal in rng.uniform(model.lower, model.upper, (3, 2, len(model.joints))):
        anchor = ahead(case, q, rng)
        reference = None
        if POTENTIALS[case.potential].reference:
            reference = measure(case, goal, anchor).value
        here = evaluate(law, measure(case, q, anchor), reference)
        slopes = [
            evaluate(law, measure(case, q + step, anchor), reference).phi
            - evaluate(law, measure(case, q - step, anchor), reference).phi
            for step in SMALL * np.eye(len(q))
        ]
        np.testing.assert_allclose(
            gradient(case.potential, here), np.array(slopes) / (2 * SMALL), rtol=1e-5, atol=1e-6
        )


def test_cases_cover_every_potential_and_both_arms() -> None:
    """Try all potentials but those solved on a grid, which have tests of their own."""
    tried = {case.potential for case in CASES}
    own = {name: each for name, each in POTENTIALS.items() if POTENTIALS.registry.is_builtin(name)}
    assert tried == {name for name, potential in own.items() if not potential.field}
    of_dexter = {case.effector for case in CASES if case.robot == "dexter"}
    assert of_dexter >= {"left_arm", "right_arm", "arms"}
    assert {case.robot for case in CASES} == set(ROBOTS)
