"""Curvature of rows: every row that bends, against differences of its Jacobian."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.numeric.compiled import compiled_once
from cbdsl.robot.resources import resources
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.table.curvature import BENDING, bend_row
from cbdsl.sensing.table.refresh import CONTACT, HEADING, TIP
from cbdsl.sensing.vision.regions.camera import heading
from cbdsl.sensing.vision.signals.chosen_headings import _Lines
from cbdsl.sensing.vision.vision import SeenHeading
from cbdsl.types.resource import MarkHeading, NetForces, Resource
from cbdsl.yaml_text.library import Library, shipped

LIBRARY = Library(shipped())
ROBOTS = sorted(path.stem for path in (shipped() / "robots").glob("*.yaml"))
STEP = 1e-5  # rad


@compiled_once
def bend(number, table, tree, bends) -> None:  # type: ignore[no-untyped-def]
    bend_row(table.records[number], table, tree, bends)


class Robot:
    """A robot in contact with all fingers, whose cameras see a distant target in every channel."""

    def __init__(self, name: str) -> None:
        path = LIBRARY.locate(RobotDocument, name)
        self.document = LIBRARY.read(path, RobotDocument).document
        self.kinematics = Kinematics(self.document, path.parent / self.document.model)
        self.resources = resources(self.document)
        self.signals = Signals(self.document, self.kinematics, self.resources.values())
        self.cells = self.signals.touch.cells
        self.joints = len(self.kinematics.lower)
        self.look = {each: np.zeros(3) for each in self.document.cameras}
        vision = self.signals.vision
        vision.number = lambda channel, instance: 0  # type: ignore[method-assign]
        vision.memory = lambda channel, number=None: None  # type: ignore[method-assign]
        vision.region = lambda camera, channel, number=None: None  # type: ignore[method-assign]
        vision.heading = self.see  # type: ignore[method-assign]

    def see(self, camera: str, channel: str, number: int | None = None) -> SeenHeading:
        frame = self.kinematics.frame(self.document.cameras[camera].link)
        return SeenHeading(heading(frame.rotation.T @ self.look[camera]), 1)

    def begin(self, q: np.ndarray, rng: np.random.Generator) -> None:
        """Choose targets in front of the cameras, and press with every finger."""
        self.signals.reset()
        self.place(q, 0.0)
        self.place(q, 5.0)
        frames = [self.kinematics.frame(eye.link) for eye in self.document.cameras.values()]
        ahead = np.array([0.8, *rng.uniform(-0.5, 0.5, 2)])
        for camera, frame in zip(self.document.cameras, frames, strict=True):
            target = frames[0].position + frames[0].rotation @ ahead
            self.look[camera] = target - frame.position
        for resource in self.resources.values():
            if isinstance(resource.source, MarkHeading):
                self.signals.sensors.marks._kept[resource.source] = _Lines(self.look, 1, 0.0)

    def place(self, q: np.ndarray, load: float = 5.0) -> None:
        loads = {cell: np.full(6, load) for cell in self.cells}
        self.signals.update(Observation(0.0, q, np.zeros(self.joints), loads, {}))

    def rows(self, number: int) -> np.ndarray:
        self.signals.refresh(self.signals.select([number]))
        rows: np.ndarray = self.signals.table.rows(number).copy()
        return rows

    def bends(self, number: int) -> np.ndarray:
        self.rows(number)
        _, table, tree = self.signals.arrays
        bends = np.zeros((table.records["rows"][number], self.joints, self.joints))
        bend(number, table, tree, bends)
        return bends


def bending(robot: Robot) -> Iterator[tuple[Resource, int]]:
    """Yield one resource of each bending row."""
    seen = set()
    for resource in robot.resources.values():
        if resource.is_drawn:
            continue
        number = robot.signals.bind(resource)
        if robot.signals.table.records["kind"][number] in BENDING and number not in seen:
            seen.add(number)
            yield resource, number


@pytest.fixture(params=ROBOTS)
def robot(request: pytest.FixtureRequest) -> Robot:
    rng = np.random.default_rng(3)
    robot = Robot(request.param)
    robot.begin(rng.uniform(-0.5, 0.5, robot.joints), rng)
    return robot


def test_bend_row_of_every_bending_resource_is_the_derivative_of_its_jacobian(
    robot: Robot,
) -> None:
    q, kinds = robot.signals.positions.copy(), set()
    for resource, number in bending(robot):
        kind, bends = int(robot.signals.table.records["kind"][number]), robot.bends(number)
        assert robot.signals.table.is_defined(number), resource.name
        # A wrench has forces above torques, which count as linear.
        linear = bends[:3] if resource.type.name == "wrench" else bends
        for joint in range(robot.joints):
            change = STEP * np.eye(robot.joints)[joint]
            robot.place(q + change)
            after = robot.rows(number)
            robot.place(q - change)
            slope = (after - robot.rows(number))[: len(linear)] / (2 * STEP)
            scale = max(1.0, float(np.abs(slope).max()))
            np.testing.assert_allclose(
                linear[:, :, joint], slope, atol=1e-6 * scale, err_msg=resource.name
            )
        kinds.add(kind)
        robot.place(q)
    expected = {TIP}
    expected |= {HEADING} if robot.document.cameras else set()
    expected |= {CONTACT} if robot.document.load_cells else set()
    assert expected <= kinds


def test_bend_row_along_a_palms_normal_is_that_component_of_the_net_forces(robot: Robot) -> None:
    for resource in robot.resources.values():
        if not isinstance(resource.source, NetForces):
            continue
        palm, net = robot.signals.bind_normal_forces(resource.source), robot.signals.bind(resource)
        hands = robot.signals.touch.hands(resource.source.group)
        normals = [robot.signals.tips.normal(robot.signals.touch.carriers[hand]) for hand in hands]
        forces = robot.bends(net).reshape(len(hands), 3, robot.joints, robot.joints)
        expected = np.einsum("hk,hkij->hij", normals, forces)
        np.testing.assert_allclose(robot.bends(palm), expected, atol=1e-9)
