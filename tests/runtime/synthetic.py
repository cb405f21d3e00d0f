"""A world without physics, for tests of the runtime: a painted ball and springy fingertips."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from cbdsl.documents.robot import Camera, RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.numeric.arrays import Floats, Image
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.vision.regions.camera import sight

GREY, RED = (128, 128, 128), (255, 0, 0)


@dataclass
class Ball:
    """Centre in the world frame, m, shape (3,); radius, m; colour, RGB."""

    position: Floats
    radius: float = 0.07
    color: tuple[int, int, int] = RED


@dataclass
class World:
    """Synthetic world, controlled by the tests.

    Attributes:
        ball: Ball that the cameras see, if any.
        contact_angle: Flexion, rad, past which a finger of any hand presses on something.
        blocked: Joints that do not follow their references.
        broken: Replacement loads of a cell, shape (6,), by (hand, finger).
    """

    ball: Ball | None = None
    contact_angle: float = math.inf
    blocked: tuple[str, ...] = ()
    broken: dict[tuple[str, str], Floats] = field(default_factory=dict)


class SyntheticBackend:
    """Body whose joints reach their references at once, in a world that tests direct.

    Args:
        robot, urdf: Arguments of every backend.
        begin: Function that makes the world of an episode; may draw from the generator.
        direct: Function that changes the world after each step, given the time in s.
    """

    renderer = "numpy"
    deadline: float | None = None

    def __init__(
        self,
        robot: RobotDocument,
        urdf: Path,
        begin: Callable[[np.random.Generator], World] = lambda rng: World(),
        direct: Callable[[World, float], None] = lambda world, time: None,
    ) -> None:
        self._robot = robot
        self._kinematics = Kinematics(robot, urdf)
        self._joints = self._kinematics.joints
        self._begin, self._direct = begin, direct
        self._sights = {name: _sights(camera) for name, camera in robot.cameras.items()}
        self._frames_per_tick = robot.vision.rate / robot.control.rate
        self.control_period = 1 / robot.control.rate
        #: All references of the last episode.
        self.applied: list[Floats] = []
        self.halts = 0

    def reset(
        self,
        stage: StageDocument,
        context: str | None,
        rng: np.random.Generator,
        channels: Collection[str] | None = None,
    ) -> str:
        """Start the joints as the stage says; show none of its objects."""
        name = context or str(rng.choice(list(stage.contexts)))
        self._positions = np.clip(0.0, self._kinematics.lower, self._kinematics.upper)
        for effector, settings in self._robot.effectors.items():
            if settings.start is not None:
                self._positions[self._joints.of(effector)] = settings.postures[settings.start]
        for joint, span in stage.contexts[name].joints.items():
            self._positions[self._joints.index[joint]] = rng.uniform(*span)
        self._tick = 0
        self.applied = []
        self._velocities = np.zeros_like(self._positions)
        self.world = self._begin(rng)
        return name

    def observe(self) -> Observation:
        self._kinematics.update(self._positions)
        frame = math.floor(self._tick * self._frames_per_tick + 1e-6)
        before = math.floor((self._tick - 1) * self._frames_per_tick + 1e-6)
        return Observation(
            time=self._tick * self.control_period,
            positions=self._positions.copy(),
            velocities=self._velocities.copy(),
            loads=self._loads(),
            images={name: self._paint(name) for name in self._sights} if frame > before else {},
        )

    def apply(self, reference: Floats) -> None:
        self.applied.append(reference.copy())

    def step(self) -> None:
        wanted = self.applied[-1].copy()
        blocked = self._joints.pick(self.world.blocked).astype(int)
        wanted[blocked] = self._positions[blocked]
        self._velocities = (wanted - self._positions) / self.control_period
        self._positions = wanted
        self._tick += 1
        self._direct(self.world, self._tick * self.control_period)

    def halt(self) -> None:
        self.halts += 1

    def close(self) -> None:
        """Release nothing."""

    def _loads(self) -> dict[tuple[str, str], Floats]:
        loads = {}
        for hand, cells in self._robot.load_cells.items():
            for finger, cell in cells.items():
                angle = self._positions[self._joints.index[cell.joint]]
                excess = max(angle - self.world.contact_angle, 0.0)
                normal = self._kinematics.frame(cell.link).rotation @ np.array(cell.normal)
                body = self._kinematics.inertial(cell.link)
                weight = np.array([0.0, 0.0, 9.81 * body.mass if body else 0.0])
                force = self._robot.control.stiffness * excess * normal
                felt = self.world.broken.get((hand, finger), np.r_[force, np.zeros(3)])
                loads[hand, finger] = felt + np.r_[weight, np.zeros(3)]
        return loads

    def _paint(self, name: str) -> Image:
        """Paint a pixel of the ball where its line of sight meets it."""
        sights = self._sights[name]
        image = np.full(sights.shape, GREY, np.uint8)
        ball = self.world.ball
        if ball is not None:
            frame = self._kinematics.frame(self._robot.cameras[name].link)
            centre = frame.rotation.T @ (ball.position - frame.position)
            along: Any = sights @ centre
            image[along > math.sqrt(max(float(centre @ centre) - ball.radius**2, 0.0))] = ball.color
        return image


def _sights(camera: Camera) -> Floats:
    """Return unit vectors along all pixels' lines of sight, camera frame, shape (h, w, 3)."""
    corner, far = sight(camera, 0.5, 0.5), sight(camera, camera.width - 0.5, camera.height - 0.5)
    across = np.linspace(corner[1], far[1], camera.width)
    down = np.linspace(corner[2], far[2], camera.height)
    y, z = np.meshgrid(across, down)
    lines = np.stack([np.ones_like(y), y, z], axis=-1)
    unit: Floats = lines / np.linalg.norm(lines, axis=-1, keepdims=True)
    return unit
