"""A peer of the robot of two joints that needs no transport."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from cbdsl.extend.driver import Command, Endpoint, FaultSample, JointSample, Sample
from cbdsl_drive.backend import DrivenBackend
from cbdsl_drive.clock import Clock
from tests.driven_robot import NAMES, PERIOD, robot

_EPOCH = 1.7e9


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


def backend(peer: Peer, urdf: Path, **driver: object) -> DrivenBackend:
    """Return the backend of a robot behind a peer, with an operator who agrees to everything."""
    driven = DrivenBackend(robot(**driver), urdf, opener=lambda _, __: [peer], clock=peer.clock())
    driven.attend(Answers())
    return driven
