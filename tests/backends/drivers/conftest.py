"""A robot of two joints with one driver, and a peer that needs no transport."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.drivers.backend import DrivenBackend
from cbdsl.backends.drivers.clock import Clock
from cbdsl.backends.drivers.link import Endpoint
from cbdsl.backends.drivers.sample import Command, FaultSample, JointSample, Sample
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument

URDF = """<robot name="rail">
<link name="base"/><link name="one"/><link name="two"/>
<joint name="first" type="revolute"><parent link="base"/><child link="one"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" velocity="2" effort="10"/></joint>
<joint name="second" type="revolute"><parent link="one"/><child link="two"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" velocity="1" effort="5"/></joint>
</robot>"""
NAMES = ("first", "second")
LOWER, UPPER = np.array([-1.0, -2.0]), np.array([1.0, 2.0])
VELOCITY = np.array([2.0, 1.0])
RATE = 50.0
PERIOD = 1.0 / RATE
_EPOCH = 1.7e9


def robot(**driver: object) -> RobotDocument:
    """Return the robot, with changes of its driver."""
    section = {"kind": "ros2", "moves": ["arm"], "states": "/joint_states", "commands": "/commands"}
    return RobotDocument.model_validate(
        {
            "cbdsl": 1,
            "kind": "robot",
            "name": "rail",
            "model": "rail.urdf",
            "base": "base",
            "effectors": {"arm": {"joints": list(NAMES)}},
            "drivers": {"arm": {**section, **driver}},
            "control": {"rate": RATE, "tasks": {}},
        }
    )


@dataclass
class Peer:
    """Ideal robot in a time of its own: it reaches each reference within the next period.

    Attributes:
        time: Seconds since the start, which ``sleep`` lets pass.
        positions: Joint positions, rad.
        commands: All commands received, each with its time.
        alter: Function that changes the joint states that it sends.
        silent: True if it sends nothing.
        skew: Advance of its clock, s.
        claims: Number of claims before commands.
        rests: Number of commands before each word that none follows.
    """

    time: float = 0.0
    positions: np.ndarray = field(default_factory=lambda: np.zeros(2))
    commands: list[tuple[float, Command]] = field(default_factory=list)
    alter: Callable[[JointSample], Sequence[Sample]] = lambda sample: (sample,)
    silent: bool = False
    skew: float = 0.0
    closed: bool = False
    faults: list[FaultSample] = field(default_factory=list)
    endpoints: list[Endpoint] = field(default_factory=list)
    sent: float = -1.0
    moving: bool = True
    claims: int = 0
    rests: list[int] = field(default_factory=list)

    def clock(self) -> Clock:
        return Clock(lambda: self.time, lambda: _EPOCH + self.time, self.sleep)

    def sleep(self, seconds: float) -> None:
        self.time += max(seconds, 1e-4)

    def poll(self) -> Sequence[Sample]:
        faults, self.faults = self.faults, []
        if self.silent or self.time - self.sent < PERIOD / 2:
            return faults
        self.sent = self.time
        if self.commands and self.moving:
            self.positions = np.array(self.commands[-1][1].positions)
        stamp = _EPOCH + self.time + self.skew
        # A real sensor has noise in its last digit.
        noise = 1e-6 * math.sin(1e4 * self.time)
        sample = JointSample("arm", stamp, NAMES, tuple(self.positions + noise), (0.0, 0.0))
        return [*faults, *self.alter(sample)]

    def claim(self) -> None:
        self.claims += 1

    def send(self, driver: str, command: Command) -> None:
        self.commands.append((self.time, command))

    def rest(self) -> None:
        self.rests.append(len(self.commands))

    def survey(self) -> Sequence[Endpoint]:
        return self.endpoints

    def close(self) -> None:
        self.closed = True

    @property
    def references(self) -> np.ndarray:
        """Positions of all commands, rad, shape (commands, 2)."""
        return np.array([command.positions for _, command in self.commands]).reshape(-1, 2)


class Answers:
    """Person with answers; remembers the questions."""

    def __init__(self, *answers: bool) -> None:
        self.answers, self.questions = list(answers), list[str]()

    def confirm(self, text: str, question: str, *, released: bool) -> bool:
        self.questions.append(question)
        return self.answers.pop(0) if self.answers else True


@pytest.fixture
def urdf(tmp_path: Path) -> Path:
    path = tmp_path / "rail.urdf"
    path.write_text(URDF)
    return path


@pytest.fixture
def stage() -> StageDocument:
    head = {"cbdsl": 1, "kind": "stage", "name": "bare", "robot": "rail"}
    return StageDocument.model_validate({**head, "contexts": {"only": {}}})


def backend(peer: Peer, urdf: Path, **driver: object) -> DrivenBackend:
    """Return the backend of a robot behind a peer, with an operator who agrees to everything."""
    driven = DrivenBackend(robot(**driver), urdf, opener=lambda _, __: [peer], clock=peer.clock())
    driven.attend(Answers())
    return driven
