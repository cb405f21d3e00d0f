"""What an experimenter does with a thing while an episode runs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np
import pybullet as p
from numpy.typing import NDArray

from cbdsl.backends.bullet.pose import Pose
from cbdsl.backends.bullet.touch import Cell
from cbdsl.backends.bullet.truth import Truth

Floats = NDArray[np.float64]

#: A hand can carry a thing once its fingers have pressed with this many times the thing's weight
#: for so long, s: the first touch may be a knock.
_GRIP = 2.0
_GRIP_TIME = 0.5
_HOLDING_FORCE = 1000.0


class Deed(Protocol):
    """Something that is done in every physics step until it is finished."""

    def act(self, time: float) -> bool:
        """Do it, at this time since the episode began, s.

        Returns:
            Whether it is finished.
        """
        ...


class _Grasp:
    """The experimenter's hand on a thing: it keeps its orientation and goes where it is led."""

    def __init__(self, client: int, body: int, pose: Pose) -> None:
        self._client = client
        self._quaternion = pose.quaternion()
        self._constraint = p.createConstraint(
            body,
            -1,
            -1,
            -1,
            p.JOINT_FIXED,
            [0, 0, 0],
            [0, 0, 0],
            pose.position.tolist(),
            childFrameOrientation=self._quaternion,
            physicsClientId=client,
        )
        self.lead(pose.position)

    def lead(self, position: Floats) -> None:
        p.changeConstraint(
            self._constraint,
            jointChildPivot=position.tolist(),
            jointChildFrameOrientation=self._quaternion,
            maxForce=_HOLDING_FORCE,
            physicsClientId=self._client,
        )

    def release(self) -> None:
        p.removeConstraint(self._constraint, physicsClientId=self._client)


class Hold:
    """Hold a thing still until a hand can carry it.

    That is when every finger of the hand has touched it, and they have pressed with twice its
    weight, for half a second. Let go at the first touch, it would fall through fingers that only
    feel for it.
    """

    def __init__(
        self, client: int, truth: Truth, name: str, body: int, weight: float, cells: Sequence[Cell]
    ) -> None:
        self._truth = truth
        self._name = name
        self._pressure = _GRIP * weight
        self._cells = set(cells)
        self._firm_since = math.inf
        self._grasp = _Grasp(client, body, truth.pose(name))

    def act(self, time: float) -> bool:
        """Let go if the hand can carry the thing."""
        self._firm_since = min(self._firm_since, time) if self._gripped() else math.inf
        carried = time - self._firm_since >= _GRIP_TIME
        if carried:
            self._grasp.release()
        return carried

    def _gripped(self) -> bool:
        touches = [touch for touch in self._truth.touches(self._name) if touch.cell in self._cells]
        return {touch.cell for touch in touches} == self._cells and (
            sum(touch.pressure for touch in touches) >= self._pressure
        )


class Carry:
    """Carry a thing along at a constant horizontal velocity until the robot touches it."""

    def __init__(
        self,
        client: int,
        truth: Truth,
        name: str,
        body: int,
        velocity: tuple[float, float],
        start: float,
    ) -> None:
        self._client = client
        self._truth = truth
        self._name = name
        self._body = body
        self._velocity = np.array([*velocity, 0.0])
        self._start = start
        self._grasp: _Grasp | None = None

    def act(self, time: float) -> bool:
        """Lead it on, or leave it to the hand that touches it."""
        if self._truth.touched(self._name):
            if self._grasp:
                self._grasp.release()
            return True
        if self._grasp is None and time >= self._start:
            pose = self._truth.pose(self._name)
            self._grasp = _Grasp(self._client, self._body, pose)
            self._origin, self._start = pose.position, time
        if self._grasp is not None:
            self._grasp.lead(self._origin + (time - self._start) * self._velocity)
        return False


class Throw:
    """Give a thing a velocity once."""

    def __init__(
        self, client: int, body: int, velocity: tuple[float, float, float], start: float
    ) -> None:
        self._client = client
        self._body = body
        self._velocity = velocity
        self._start = start

    def act(self, time: float) -> bool:
        """Throw it, once its time has come."""
        if time < self._start:
            return False
        p.resetBaseVelocity(self._body, self._velocity, [0, 0, 0], physicsClientId=self._client)
        return True
