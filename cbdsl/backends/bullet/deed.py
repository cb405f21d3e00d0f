"""What an experimenter does with a thing while an episode runs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import pybullet as p

from cbdsl.backends.bullet.scene import Scene
from cbdsl.backends.bullet.touch import Cell
from cbdsl.backends.bullet.truth import Truth
from cbdsl.documents.stage import Thing

#: A hand can carry a thing once its fingers have pressed with this many times the thing's weight
#: for so long, s: the first touch may be a knock.
_GRIP = 2.0
_GRIP_TIME = 0.5
_HOLDING_FORCE = 1000.0


class Deed(Protocol):
    """Something that is done in every control period until it is finished."""

    def act(self, time: float) -> bool:
        """Do it, at this time since the episode began, s.

        Returns:
            Whether it is finished.
        """
        ...


class Hold:
    """Hold a thing still until a hand can carry it.

    That is when every finger of the hand has touched it, and they have pressed with twice its
    weight, for half a second. Let go at the first touch, it would fall through fingers that only
    feel for it.
    """

    def __init__(
        self,
        client: int,
        scene: Scene,
        truth: Truth,
        name: str,
        weight: float,
        cells: Sequence[Cell],
    ) -> None:
        self._client = client
        self._truth = truth
        self._name = name
        self._pressure = _GRIP * weight
        self._cells = set(cells)
        self._firm_since = math.inf
        pose = truth.pose(name)
        self._constraint = p.createConstraint(
            scene.bodies[name],
            -1,
            -1,
            -1,
            p.JOINT_FIXED,
            [0, 0, 0],
            [0, 0, 0],
            pose.position.tolist(),
            childFrameOrientation=pose.quaternion(),
            physicsClientId=client,
        )
        p.changeConstraint(self._constraint, maxForce=_HOLDING_FORCE, physicsClientId=client)

    def act(self, time: float) -> bool:
        """Let go if the hand can carry the thing."""
        self._firm_since = min(self._firm_since, time) if self._gripped() else math.inf
        carried = time - self._firm_since >= _GRIP_TIME
        if carried:
            p.removeConstraint(self._constraint, physicsClientId=self._client)
        return carried

    def _gripped(self) -> bool:
        touches = [touch for touch in self._truth.touches(self._name) if touch.cell in self._cells]
        return {touch.cell for touch in touches} == self._cells and (
            sum(touch.pressure for touch in touches) >= self._pressure
        )


class Push:
    """Keep a thing at a horizontal velocity, on a slippery sole, until the robot touches it."""

    def __init__(
        self,
        client: int,
        scene: Scene,
        truth: Truth,
        name: str,
        surface: Thing,
        velocity: tuple[float, float],
        start: float,
    ) -> None:
        self._client = client
        self._scene = scene
        self._truth = truth
        self._name = name
        self._surface = surface
        self._velocity = velocity
        self._start = start
        self._moving = False

    def act(self, time: float) -> bool:
        """Keep it moving, or leave it to the hand that touches it."""
        body = self._scene.bodies[self._name]
        if self._truth.touched(self._name):
            self._scene.restore(body, self._surface)
            return True
        if time >= self._start:
            if not self._moving:
                self._scene.make_slippery(body)
                self._moving = True
            (_, _, vertical), spin = p.getBaseVelocity(body, physicsClientId=self._client)
            p.resetBaseVelocity(
                body, [*self._velocity, vertical], spin, physicsClientId=self._client
            )
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
