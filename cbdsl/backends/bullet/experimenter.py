"""The experimenter: sets up a stage, presents a thing, and does with it what the context says."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.backend import BackendError
from cbdsl.backends.bullet.deed import Carry, Deed, Hold, Throw
from cbdsl.backends.bullet.scene import Scene
from cbdsl.backends.bullet.shape import Shape, draw
from cbdsl.backends.bullet.truth import Truth
from cbdsl.backends.pose import Pose
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import Context, Motion, Place, StageDocument

Floats = NDArray[np.float64]
_Entry = TypeVar("_Entry")

_UP = np.array([0.0, 0.0, 1.0])
_ACROSS = np.array([0.0, 1.0, 0.0])


def _named(entries: Mapping[str, _Entry], name: str, kind: str, stage: str) -> _Entry:
    if name not in entries:
        known = ", ".join(entries) or "none"
        raise BackendError(f"stage '{stage}' names the {kind} '{name}'; there is: {known}")
    return entries[name]


class Experimenter:
    """Acts in the world as a person would beside the robot, and sees all of it.

    Args:
        client: the simulator.
        stage: what there is to show.
        robot: whose hands things can be held out to.
        scene: where fixtures and things are put.
        truth: what the experimenter sees.
        rng: draws what the stage leaves to chance.
    """

    def __init__(
        self,
        client: int,
        stage: StageDocument,
        robot: RobotDocument,
        scene: Scene,
        truth: Truth,
        rng: np.random.Generator,
    ) -> None:
        self._client = client
        self._stage = stage
        self._robot = robot
        self._scene = scene
        self._truth = truth
        self._rng = rng
        self._tops: dict[str, float] = {}
        self._deeds: list[Deed] = []
        self._shown: str | None = None
        self._removal = math.inf

    def furnish(self) -> None:
        """Put up the stage's fixtures."""
        for name, fixture in self._stage.fixtures.items():
            shape = Shape.draw(fixture.form, self._rng)
            self._tops[name] = fixture.position[2] + shape.half_height
            pose = Pose(np.array(fixture.position), np.eye(3))
            self._scene.add(name, shape, fixture, 0.0, pose)

    def present(self, context: Context) -> None:
        """Show one of the context's things, if it has any, in its place.

        Raises:
            BackendError: the context names what its stage or the robot does not have.
        """
        if not context.things or context.place is None:
            return
        name = context.things[int(self._rng.integers(len(context.things)))]
        thing = _named(self._stage.things, name, "thing", self._stage.name)
        shape = Shape.draw(thing.form, self._rng)
        mass = draw(thing.mass, self._rng)
        pose = self._pose(context.place, shape.half_height)
        body = self._scene.add(name, shape, thing, mass, pose)
        self._shown = name
        if context.removed_after is not None:
            self._removal = context.removed_after
        if context.place.held:
            until = math.inf if context.released_after is None else context.released_after
            self._deeds.append(Hold(self._client, self._truth, name, body, until))
        if context.motion is not None:
            self._deeds.append(self._motion(context.motion, name, body))

    def _pose(self, place: Place, half_height: float) -> Pose:
        x, y = draw(place.x, self._rng), draw(place.y, self._rng)
        turned = Pose.turned(_UP, draw(place.yaw, self._rng))
        if place.pitch != (0.0, 0.0):  # nothing is drawn that is not asked for
            turned = turned @ Pose.turned(_ACROSS, draw(place.pitch, self._rng))
        if place.gap is not None:
            z = draw(place.gap, self._rng) + half_height
        elif place.z is not None:
            z = draw(place.z, self._rng)
        else:
            top = _named(self._tops, str(place.on), "fixture", self._stage.name)
            z = top + half_height
        pose = Pose(np.array([x, y, z]), turned.rotation)
        return pose if place.hand is None else self._tip(place.hand) @ pose

    def _tip(self, effector: str) -> Pose:
        tip = _named(self._robot.effectors, effector, "effector", self._stage.name).tip
        if tip is None:
            raise BackendError(
                f"stage '{self._stage.name}' holds something out to '{effector}', which has no tip"
            )
        return self._truth.link_pose(tip.link) @ Pose(np.array(tip.offset), np.eye(3))

    def _motion(self, motion: Motion, name: str, body: int) -> Deed:
        speed, direction = draw(motion.speed, self._rng), draw(motion.direction, self._rng)
        velocity = speed * math.cos(direction), speed * math.sin(direction)
        upward, start = draw(motion.upward, self._rng), draw(motion.after, self._rng)
        if motion.thrown:
            return Throw(self._client, body, (*velocity, upward), start)
        return Carry(self._client, self._truth, name, body, velocity, start)

    def act(self, time: float) -> bool:
        """Do what is to be done at this time since the episode began, s.

        Returns:
            Whether something was taken out of the world.
        """
        if self._shown is not None and time >= self._removal:
            self._scene.remove(self._shown)
            self._shown, self._deeds = None, []
            return True
        self._deeds = [deed for deed in self._deeds if not deed.act(time)]
        return False
