"""Scenario of an episode: what is shown, where, and what is done with it, drawn by chance."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.backend import BackendError
from cbdsl.backends.staging.pose import Pose
from cbdsl.backends.staging.shape import SolidShape
from cbdsl.backends.staging.span import draw
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import Context, Motion, PlaceSection, StageDocument, Surface

Floats = NDArray[np.float64]
_Entry = TypeVar("_Entry")

#: Acceleration of falling things, m/s^2.
GRAVITY = 9.81

_UP = np.array([0.0, 0.0, 1.0])
_ACROSS = np.array([0.0, 1.0, 0.0])


class SceneObject(NamedTuple):
    """A fixture or thing of a stage, as it is put into the world.

    Attributes:
        name: as the stage has it.
        shape: of definite size.
        surface: its colour and friction.
        mass: kg; 0 for a fixture.
        pose: of its centre.
    """

    name: str
    shape: SolidShape
    surface: Surface
    mass: float
    pose: Pose


class Movement(NamedTuple):
    """Motion of a thing that the experimenter carries along or throws.

    Attributes:
        velocity: m/s, shape (3,); level unless it is thrown.
        start: since the episode began, s.
        thrown: whether it is given its velocity once, instead of kept at it.
    """

    velocity: Floats
    start: float
    thrown: bool


@dataclass(frozen=True)
class Scenario:
    """Objects and events of one episode; times are since it began, s.

    Attributes:
        fixtures: objects that do not move.
        thing: the object that is shown besides, if any.
        held_until: when the experimenter lets go of the thing, ``None`` if nobody holds it.
        removed: when the thing is taken away.
        returned_after: how long after it has fallen it is put back, ``None`` if nobody does that.
        movement: how the thing is moved, if it is.
    """

    fixtures: tuple[SceneObject, ...]
    thing: SceneObject | None = None
    held_until: float | None = None
    removed: float = math.inf
    returned_after: float | None = None
    movement: Movement | None = None


class ScenarioSampler:
    """Samples scenarios: from equal generators equal ones, whatever backend shows them.

    Args:
        stage: what there is to show.
        robot: whose hands things can be held out to.
        link_pose: where a link of the robot is.
        rng: draws what the stage leaves to chance.
    """

    def __init__(
        self,
        stage: StageDocument,
        robot: RobotDocument,
        link_pose: Callable[[str], Pose],
        rng: np.random.Generator,
    ) -> None:
        self._stage = stage
        self._robot = robot
        self._link_pose = link_pose
        self._rng = rng

    def sample(self, context: Context) -> Scenario:
        """The stage's fixtures and one of the context's things, if it has any, in its place.

        Raises:
            BackendError: the context names what its stage or the robot does not have.
        """
        fixtures = self._fixtures()
        if not context.things or context.place is None:
            return Scenario(fixtures)
        thing = self._thing(context, context.place, fixtures)
        released = math.inf if context.released_after is None else context.released_after
        return Scenario(
            fixtures,
            thing,
            held_until=released if context.place.held else None,
            removed=math.inf if context.removed_after is None else context.removed_after,
            returned_after=context.returned_after,
            movement=None if context.motion is None else self._movement(context.motion),
        )

    def _fixtures(self) -> tuple[SceneObject, ...]:
        fixtures = []
        for name, fixture in self._stage.fixtures.items():
            shape = SolidShape.draw(fixture.form, self._rng)
            pose = Pose(np.array(fixture.position), np.eye(3))
            fixtures.append(SceneObject(name, shape, fixture, 0.0, pose))
        return tuple(fixtures)

    def _thing(
        self, context: Context, place: PlaceSection, fixtures: tuple[SceneObject, ...]
    ) -> SceneObject:
        name = context.things[int(self._rng.integers(len(context.things)))]
        thing = self._named(self._stage.things, name, "thing")
        shape = SolidShape.draw(thing.form, self._rng)
        mass = draw(thing.mass, self._rng)
        pose = self._pose(place, shape.half_height, fixtures)
        return SceneObject(name, shape, thing, mass, pose)

    def _pose(
        self, place: PlaceSection, half_height: float, fixtures: tuple[SceneObject, ...]
    ) -> Pose:
        x, y = draw(place.x, self._rng), draw(place.y, self._rng)
        turned = Pose.turned(_UP, draw(place.yaw, self._rng))
        if place.pitch != (0.0, 0.0):  # nothing is drawn that is not asked for
            turned = turned @ Pose.turned(_ACROSS, draw(place.pitch, self._rng))
        if place.gap is not None:
            z = draw(place.gap, self._rng) + half_height
        elif place.z is not None:
            z = draw(place.z, self._rng)
        else:
            known = {fixture.name: fixture for fixture in fixtures}
            floor = self._named(known, str(place.on), "fixture")
            z = float(floor.pose.position[2]) + floor.shape.half_height + half_height
        pose = Pose(np.array([x, y, z]), turned.rotation)
        return pose if place.hand is None else self._tip(place.hand) @ pose

    def _tip(self, effector: str) -> Pose:
        tip = self._named(self._robot.effectors, effector, "effector").tip
        if tip is None:
            raise BackendError(
                f"stage '{self._stage.name}' holds something out to '{effector}', which has no tip"
            )
        return self._link_pose(tip.link) @ Pose(np.array(tip.offset), np.eye(3))

    def _movement(self, motion: Motion) -> Movement:
        speed, direction = draw(motion.speed, self._rng), draw(motion.direction, self._rng)
        upward, start = draw(motion.upward, self._rng), draw(motion.after, self._rng)
        rising = upward if motion.thrown else 0.0
        velocity = np.array([speed * math.cos(direction), speed * math.sin(direction), rising])
        return Movement(velocity, start, motion.thrown)

    def _named(self, entries: Mapping[str, _Entry], name: str, kind: str) -> _Entry:
        if name not in entries:
            known = ", ".join(entries) or "none"
            raise BackendError(
                f"stage '{self._stage.name}' names the {kind} '{name}'; there is: {known}"
            )
        return entries[name]
