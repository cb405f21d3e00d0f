"""Balls on a table before the robot, and its memory of them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import cbdsl
from cbdsl.api.control import Floats, Frame, Kinematics
from cbdsl.api.documents import StageDocument
from cbdsl.api.sensing import Runner, Signals, resources, within_view
from cbdsl.api.shipped import shipped_folder, shipped_robot
from cbdsl.api.trials import embody_simulated

_TOP = -0.42  # of the table, m
COLORS = {"red": [1, 0, 0], "blue": [0, 0.4, 1]}
TABLE = {"form": {"shape": "box", "size": [0.6, 1.2, 0.04]}, "position": [0.6, 0, -0.44]}
RIGHT = 0.01  # largest error of a right position, m
RUN = 0.05  # least displacement of an object that has run away, m
_SWAY = 0.02  # by how much the head turns to both sides, rad
AWAY = {"pan": 1.4, "tilt": -0.3}
CARRYING = {"pan": -0.25, "tilt": 1.1}


# Program that carries a ball above another.
_CARRY = """\
cbdsl: 1
kind: program
name: carry
robot: dexter
parameters: {feature: red.1, goal: blue}
use:
  reachtouch: {program: reachtouch, with: {feature: $feature}}
controllers:
  hold:
    potential: spring
    reference: 6 N along normals
    feedback: right_hand.finger_forces
    effector: right_hand
    gain: 0.1 /s
    seek: {until: 1.5 rad}
    quiescence: {rate: 5, window: 0.5 s}
  carry:
    requires: hold
    potential: spring
    reference: stereo.$goal
    feedback: right_arm.position
    effector: right_arm.position
    speed: 25 cm/s
    standoff: {clearance: 16 cm, least: 22 cm, most: 30 cm}
  orient:
    requires: hold
    potential: spring
    reference: [180 deg, 0 deg, 0 deg]
    feedback: right_arm.orientation
    effector: right_arm.orientation
    free_axis: z
  above: orient ◁ carry ◁ hold
actions: [reachtouch, above]
policy: {XX: reachtouch, 0X: reachtouch, 1X: above, X0: above, X1: above}
limits: {transitions: 100, transition_time: 12 s}
"""


class TableBall(NamedTuple):
    """Ball on the table: centre, m, shape (3,), radius, m, and the channel of its colour."""

    centre: Floats
    radius: float
    channel: str


class Rig:
    """The robot before some balls.

    Args:
        backend: Name of the engine.
        cameras: ``rendered`` or ``ideal``.
    """

    def __init__(self, backend: str, cameras: str | None) -> None:
        self.robot, urdf = shipped_robot("dexter")
        self._kinematics = Kinematics(self.robot, urdf)
        self.backend = embody_simulated(backend, self.robot, urdf, cameras=cameras)
        named = resources(self.robot)
        self.signals = Signals(self.robot, self._kinematics, [named[f"stereo.{c}"] for c in COLORS])
        self.ghosts = 0

    def frames(self, **joints: float) -> list[Frame]:
        """Return the frames of the cameras at some joints of the head."""
        positions = np.clip(0.0, self._kinematics.lower, self._kinematics.upper)
        for name, angle in joints.items():
            positions[self._kinematics.joints.index[name]] = angle
        self._kinematics.update(positions)
        return [self._kinematics.frame(camera.link) for camera in self.robot.cameras.values()]

    def are_whole(self, balls: list[TableBall], **joints: float) -> bool:
        """Return True if both cameras see all of each ball, with a margin and unoccluded."""
        for camera, frame in zip(self.robot.cameras.values(), self.frames(**joints), strict=True):
            lines = [ball.centre - frame.position for ball in balls]
            for ball, line in zip(balls, lines, strict=True):
                if not within_view(camera, frame.rotation.T @ line, 1.15 * ball.radius):
                    return False
            for (one, a), (other, b) in combinations(zip(balls, lines, strict=True), 2):
                far, farther = math.hypot(*a), math.hypot(*b)
                # A ball of radius r at a distance d appears with the angular radius asin(r / d).
                # Images of two balls are separate if the angle between their middles exceeds the
                # sum of both.
                between = math.acos(float(a @ b) / far / farther)
                sizes = math.asin(one.radius / far) + math.asin(other.radius / farther)
                if between < sizes + 2 * _SWAY * 0.1:
                    return False
        return True

    def show(self, balls: list[TableBall], rng: np.random.Generator, **joints: float) -> None:
        """Begin a new world with some balls."""
        fixtures = {"table": TABLE | {"color": [0.6, 0.45, 0.3]}} | {
            f"ball_{number}": {
                "form": {"shape": "ball", "radius": ball.radius},
                "position": ball.centre.tolist(),
                "color": COLORS[ball.channel],
            }
            for number, ball in enumerate(balls)
        }
        stage = stage_of(fixtures=fixtures, contexts={"all": {"joints": joints}})
        self.backend.reset(stage, None, rng, list(COLORS))
        self.signals.reset()
        self.balls = balls
        self._reference = self.backend.observe().positions.copy()
        self.ghosts = 0

    def look(self, seconds: float, **joints: float) -> Iterator[float]:
        """Let time pass while the head turns to some joints and sways; yields the time."""
        index = self.signals.joints.index
        for name, angle in joints.items():
            self._reference[index[name]] = angle
        period = self.backend.control_period
        for tick in range(round(seconds / period)):
            self.signals.update(self.backend.observe())
            self.ghosts += sum(1 for _ in self._strangers())
            reference = self._reference.copy()
            reference[index["pan"]] += _SWAY * math.sin(2 * math.pi * tick * period)
            self.backend.apply(reference)
            self.backend.step()
            yield (tick + 1) * period

    def memories(self, channel: str) -> Sequence[Any]:
        """Return the memories of the instances of a channel."""
        return self.signals.vision.instances[channel].memories

    def place(self, ball: TableBall) -> tuple[int, float] | None:
        """Return the number of the memory nearest to a ball, and its distance, m."""
        memories = self.memories(ball.channel)
        errors = [
            (math.dist(memory.position, ball.centre), number)
            for number, memory in enumerate(memories)
            if memory.position is not None
        ]
        return min(((number, error) for error, number in errors), key=lambda e: e[1], default=None)

    def numbers(self) -> list[int | None]:
        """Return numbers of the balls that are remembered at the right place."""
        places = [self.place(ball) for ball in self.balls]
        return [None if place is None or place[1] > RIGHT else place[0] for place in places]

    def _strangers(self) -> Iterator[Any]:
        """Yield the memories outside of every ball of their hue."""
        for channel in COLORS:
            own = [ball for ball in self.balls if ball.channel == channel]
            for memory in self.memories(channel):
                position = memory.position
                if position is not None and all(
                    math.dist(position, ball.centre) > ball.radius for ball in own
                ):
                    yield memory

    def shows(self, ball: TableBall) -> bool:
        """Return True if both cameras are turned to a ball's place now."""
        return all(
            within_view(camera, pose.rotation.T @ (ball.centre - pose.position), 1.05 * ball.radius)
            for camera in self.robot.cameras.values()
            for pose in [self.backend.truth.link_pose(camera.link)]
        )

    def runner(self, goal: str, folder: Path) -> Runner:
        """Return the runner of the program that carries a ball above another."""
        file = folder / "carry.yaml"
        file.write_text(_CARRY, encoding="utf-8")
        request = cbdsl.load(
            file, stage="table_right", values={"goal": goal}, folder=shipped_folder()
        )
        return Runner(self.robot, self._kinematics, request.program, self.backend)

    def close(self) -> None:
        """End the simulation."""
        self.backend.close()


def stage_of(**sections: Any) -> StageDocument:
    """Return a stage of the robot with some sections."""
    head = {"cbdsl": 1, "kind": "stage", "name": "balls", "robot": "dexter"}
    return StageDocument.model_validate(head | sections)


def drawn(rng: np.random.Generator, wide: bool = False) -> list[TableBall]:
    """Return three balls, two of one hue, with 2 cm or more between them."""
    balls: list[TableBall] = []
    aside = 0.4 if wide else 0.22
    while len(balls) < 3:
        radius = rng.uniform(0.03, 0.07)
        centre = np.array([rng.uniform(0.4, 0.8), rng.uniform(-aside, aside), _TOP + radius])
        if all(math.dist(centre, b.centre) > radius + b.radius + 0.02 for b in balls):
            balls.append(TableBall(centre, radius, "blue" if len(balls) == 2 else "red"))
    return balls


def drawn_in_view(rig: Rig, rng: np.random.Generator) -> tuple[list[TableBall], dict[str, float]]:
    """Return balls that both cameras see whole while the head sways, and its joints."""
    while True:
        balls = drawn(rng)
        joints = {"pan": rng.uniform(-0.1, 0.1), "tilt": rng.uniform(0.85, 1.2)}
        sways = (joints["pan"] - _SWAY, joints["pan"] + _SWAY)
        if all(rig.are_whole(balls, pan=pan, tilt=joints["tilt"]) for pan in sways):
            return balls, joints


def drawn_for_carrying(rig: Rig, channel: str, rng: np.random.Generator) -> dict[str, TableBall]:
    """Return two balls within reach that both cameras see whole, 10 cm or more apart."""
    while True:
        balls = []
        for each in ("red", channel):
            radius = rng.uniform(0.04, 0.06)
            centre = rng.uniform(0.45, 0.65), rng.uniform(-0.35, -0.05), _TOP + radius
            balls.append(TableBall(np.array(centre), radius, each))
        one, other = balls
        gap = math.dist(one.centre, other.centre) - one.radius - other.radius
        if gap > 0.1 and rig.are_whole(balls, **CARRYING):
            return {"taken": one, "goal": other}


def exhaust(times: Iterator[float]) -> None:
    """Let all of the time pass."""
    for _ in times:
        pass
