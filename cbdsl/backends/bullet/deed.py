"""What an experimenter does with a thing while an episode runs."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import pybullet as p
from numpy.typing import NDArray

from cbdsl.backends.bullet.truth import Truth
from cbdsl.backends.staging.fall import Fall
from cbdsl.backends.staging.pose import Pose
from cbdsl.backends.staging.presentation import Movement

Floats = NDArray[np.float64]

_HOLDING_FORCE = 1000.0
# What is put back keeps this far from the robot, m.
_ROOM = 0.03


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
    """Hold a thing still, whatever presses against it, until a time since the episode began, s."""

    def __init__(self, client: int, truth: Truth, name: str, body: int, until: float) -> None:
        self._until = until
        self._grasp = _Grasp(client, body, truth.pose(name))

    def act(self, time: float) -> bool:
        """Let go when it is time."""
        over = time >= self._until
        if over:
            self._grasp.release()
        return over


class Carry:
    """Carry a thing along at a constant horizontal velocity until the robot touches it."""

    def __init__(
        self,
        client: int,
        truth: Truth,
        name: str,
        body: int,
        movement: Movement,
    ) -> None:
        self._client = client
        self._truth = truth
        self._name = name
        self._body = body
        self._velocity, self._start = movement.velocity, movement.start
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

    def __init__(self, client: int, body: int, movement: Movement) -> None:
        self._client = client
        self._body = body
        self._movement = movement

    def act(self, time: float) -> bool:
        """Throw it, once its time has come."""
        if time < self._movement.start:
            return False
        velocity = self._movement.velocity.tolist()
        p.resetBaseVelocity(self._body, velocity, [0, 0, 0], physicsClientId=self._client)
        return True


class Return:
    """Put a thing back where it was shown, a while after it fell from there."""

    def __init__(self, client: int, truth: Truth, name: str, body: int, delay: float) -> None:
        self._client = client
        self._truth = truth
        self._name = name
        self._body = body
        self._place = truth.pose(name)
        self._fall = Fall(float(self._place.position[2]), delay)

    def act(self, time: float) -> bool:
        """Put it back when it is time, as soon as the robot is not in the way."""
        pose = self._truth.pose(self._name)
        touched = self._truth.touched(self._name)
        if self._fall.is_due(float(pose.position[2]), time, touched=touched):
            velocity = p.getBaseVelocity(self._body, physicsClientId=self._client)
            self._put(self._place, ([0, 0, 0], [0, 0, 0]))
            if self._truth.is_near(self._name, _ROOM):
                self._put(pose, velocity)
        return False

    def _put(self, pose: Pose, velocity: tuple[list[float], list[float]]) -> None:
        where = pose.position.tolist(), pose.quaternion()
        p.resetBasePositionAndOrientation(self._body, *where, physicsClientId=self._client)
        p.resetBaseVelocity(self._body, *velocity, physicsClientId=self._client)
