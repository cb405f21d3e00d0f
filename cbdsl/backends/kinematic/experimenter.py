"""The experimenter: sets up a stage, presents a thing, and does with it what the context says."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.backend import BackendError
from cbdsl.backends.kinematic.shape import Shape, draw
from cbdsl.backends.kinematic.thing import Thing
from cbdsl.backends.kinematic.tree import Tree
from cbdsl.backends.kinematic.world import World
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

    What is left to chance is drawn in the order in which the bullet backend draws it, so that the
    same seed shows the same thing at the same place.

    Args:
        stage: what there is to show.
        robot: whose hands things can be held out to.
        tree: where those hands are.
        world: where fixtures and things are put.
        rng: draws what the stage leaves to chance.
    """

    def __init__(
        self,
        stage: StageDocument,
        robot: RobotDocument,
        tree: Tree,
        world: World,
        rng: np.random.Generator,
    ) -> None:
        self._stage = stage
        self._robot = robot
        self._tree = tree
        self._world = world
        self._rng = rng
        self._release = self._removal = self._start = math.inf
        self._velocity: Floats = np.zeros(3)
        self._throws = False
        self.shown: Thing | None = None

    def furnish(self) -> None:
        """Put up the stage's fixtures."""
        for name, fixture in self._stage.fixtures.items():
            shape = Shape.draw(fixture.form, self._rng)
            pose = Pose(np.array(fixture.position), np.eye(3))
            self._world.add(name, shape, fixture, 0.0, pose)

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
        self.shown = self._world.add(name, shape, thing, mass, pose)
        if context.removed_after is not None:
            self._removal = context.removed_after
        if context.place.held:
            self.shown.gripped = True
            if context.released_after is not None:
                self._release = context.released_after
        if context.motion is not None:
            self._plan(context.motion)

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
            floor = _named(self._world.things, str(place.on), "fixture", self._stage.name)
            z = float(floor.position[2]) + floor.shape.half_height + half_height
        pose = Pose(np.array([x, y, z]), turned.rotation)
        return pose if place.hand is None else self._tip(place.hand) @ pose

    def _tip(self, effector: str) -> Pose:
        tip = _named(self._robot.effectors, effector, "effector", self._stage.name).tip
        if tip is None:
            raise BackendError(
                f"stage '{self._stage.name}' holds something out to '{effector}', which has no tip"
            )
        return self._tree.pose(tip.link) @ Pose(np.array(tip.offset), np.eye(3))

    def _plan(self, motion: Motion) -> None:
        speed, direction = draw(motion.speed, self._rng), draw(motion.direction, self._rng)
        upward, self._start = draw(motion.upward, self._rng), draw(motion.after, self._rng)
        self._throws = motion.thrown
        rising = upward if motion.thrown else 0.0
        self._velocity = np.array(
            [speed * math.cos(direction), speed * math.sin(direction), rising]
        )

    def act(self, time: float, *, touched: bool) -> None:
        """Do what is to be done at this time since the episode began, s.

        Args:
            touched: whether the robot touches what is shown.
        """
        thing = self.shown
        if thing is None:
            return
        if time >= self._removal:
            self._world.remove(thing.name)
            self.shown = None
            return
        if time >= self._release:
            thing.gripped, self._release = False, math.inf
        if self._throws:
            self._throw(thing, time)
        elif touched and self._start < math.inf:
            # What is carried along is left to the hand that touches it.
            thing.gripped, self._start = False, math.inf
            thing.launch(np.zeros(3))
        elif time >= self._start and not thing.gripped:
            thing.gripped = True
            thing.launch(self._velocity)

    def _throw(self, thing: Thing, time: float) -> None:
        if time >= self._start:
            thing.launch(self._velocity)
            self._throws, self._start = False, math.inf
