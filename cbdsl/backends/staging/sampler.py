"""Scenario sampler: draws all values that a context leaves to chance."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from graphlib import CycleError, TopologicalSorter
from itertools import combinations, product
from typing import NamedTuple, TypeVar

import numpy as np

from cbdsl.backends.backend import BackendError
from cbdsl.backends.staging.scenario import Movement, PlacedThing, Scenario, SceneObject
from cbdsl.backends.staging.shape import SolidShape, draw
from cbdsl.documents.context import Context, Motion, PlaceSection, Presentation
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.convex import Convex, gap

_Entry = TypeVar("_Entry")

# Largest number of scenes that are drawn until one fits.
_TRIES = 1000

_UP = np.array([0.0, 0.0, 1.0])
_ACROSS = np.array([0.0, 1.0, 0.0])


class ScenarioSampler:
    """Sampler of scenarios from contexts of a stage.

    Args:
        stage: Stage with the contexts.
        robot: Robot document, with the tips in whose reach things are held.
        link_pose: Function that returns poses of the robot's links at the start.
        rng: Only source of chance.
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
        """Return the stage's fixtures and the context's things in their places.

        If there are several things, or fixtures without a fixed place, all are drawn together.
        Drawing repeats until no thing overlaps another, and they are as far apart as the context
        requests: every scene that fits is equally likely.

        Raises:
            BackendError: The context names a part that its stage or the robot does not have, or no
                scene was found in which its things have room.
        """
        drawn = any(fixture.is_drawn for fixture in self._stage.fixtures.values())
        # A single unnamed object has no required distance from others, and fixed fixtures need no
        # draw.
        if not context.placed and not drawn:
            return self._draw(context)
        apart = {name: each.apart for name, each in context.placed.items()}
        supports = {name: each.place.on for name, each in context.placed.items()}
        conflicts: Counter[Conflict] = Counter()
        # Rejection sampling of whole scenes. Another draw of the conflicting object alone would not
        # be uniform: crowded places of the first objects would be as likely as free ones.
        for _ in range(_TRIES):
            scenario = self._draw(context)
            conflict = find_conflict(scenario, apart, supports)
            if conflict is None:
                return scenario
            conflicts[conflict] += 1
        ((conflict, count),) = conflicts.most_common(1)
        raise BackendError(
            f"stage '{self._stage.name}' has no room for its things: in {_TRIES} scenes that were "
            f"drawn, most often ({count} times) {conflict}; give them more room"
        )

    def place_again(self, context: Context, scenario: Scenario, name: str) -> Pose | None:
        """Return another place for one thing of a scene, with the others where they are.

        Args:
            context: Context of the scene.
            scenario: Current scene.
            name: Name of the thing.

        Returns:
            New pose; ``None`` if there is no room for it.
        """
        presentation = context.presentations.get(name) or context.presentations.get(None)
        item = next(thing.item for thing in scenario.things if thing.item.name == name)
        if presentation is None or presentation.place is None:
            return None
        known = {f.name: f for f in scenario.fixtures}
        known |= {thing.item.name: thing.item for thing in scenario.things}
        place, half = presentation.place, item.shape.half_height
        return self._fitting(context, scenario, item, lambda: self._pose(place, half, known))

    def scatter(self, context: Context, scenario: Scenario, name: str, home: Pose) -> Pose | None:
        """Return a place around the original place of a thing; see ``place_again``."""
        thing = next(thing for thing in scenario.things if thing.item.name == name)
        own = thing.scattered
        if own is None:
            return None

        def draw_place() -> Pose | None:
            way = self._rng.normal(0.0, own.deviation, 2)
            x, y = (home.position[:2] + way).tolist()
            if not (own.x[0] <= x <= own.x[1] and own.y[0] <= y <= own.y[1]):
                return None
            return Pose(np.array([x, y, home.position[2]]), home.rotation)

        return self._fitting(context, scenario, thing.item, draw_place)

    def _fitting(
        self,
        context: Context,
        scenario: Scenario,
        item: SceneObject,
        draw_place: Callable[[], Pose | None],
    ) -> Pose | None:
        """Return the first of the drawn places at which a thing overlaps no other."""
        apart = {name: each.apart for name, each in context.placed.items()}
        supports = {name: each.place.on for name, each in context.placed.items()}
        others = tuple(thing for thing in scenario.things if thing.item.name != item.name)
        for _ in range(_TRIES):
            pose = draw_place()
            if pose is None:
                continue
            things = (*others, PlacedThing(item._replace(pose=pose)))
            if find_conflict(Scenario(scenario.fixtures, things), apart, supports) is None:
                return pose
        return None

    def _draw(self, context: Context) -> Scenario:
        """Return a scene whose things may overlap."""
        fixtures = self._fixtures()
        known = {fixture.name: fixture for fixture in fixtures}
        things = []
        for name, presentation in self._ordered(context):
            if presentation.things and presentation.place is not None:
                item = self._item(name, presentation, presentation.place, known)
                known[item.name] = item
                things.append(self._placed(item, presentation, presentation.place))
        return Scenario(fixtures, tuple(things))

    def _ordered(self, context: Context) -> list[tuple[str | None, Presentation]]:
        """Return all presentations of a context, each after its neighbours."""
        presentations = context.presentations
        before = {
            name: [each for each in presentation.place.neighbours if each in context.placed]
            for name, presentation in context.placed.items()
        }
        try:
            order = [*TopologicalSorter(before).static_order()] if before else list(presentations)
        except CycleError as error:
            circle = " -> ".join(error.args[1])
            raise BackendError(
                f"stage '{self._stage.name}' places things on or beside each other in a circle: "
                f"{circle}"
            ) from error
        return [(name, presentations[name]) for name in order]

    def _fixtures(self) -> tuple[SceneObject, ...]:
        fixtures = []
        for name, fixture in self._stage.fixtures.items():
            shape = SolidShape.draw(fixture.form, self._rng)
            # Only values that are left to chance are drawn.
            position = [
                first if first == last else draw((first, last), self._rng)
                for first, last in fixture.position
            ]
            pose = Pose(np.array(position), np.eye(3))
            fixtures.append(SceneObject(name, shape, fixture, 0.0, pose))
        return tuple(fixtures)

    def _item(
        self,
        name: str | None,
        presentation: Presentation,
        place: PlaceSection,
        known: Mapping[str, SceneObject],
    ) -> SceneObject:
        """Return one of a presentation's things in its place; without a name it keeps its own."""
        drawn = presentation.things[int(self._rng.integers(len(presentation.things)))]
        thing = self._named(self._stage.things, drawn, "thing")
        shape = SolidShape.draw(thing.form, self._rng)
        mass = draw(thing.mass, self._rng)
        pose = self._pose(place, shape.half_height, known)
        return SceneObject(name or drawn, shape, thing, mass, pose)

    def _placed(
        self, item: SceneObject, presentation: Presentation, place: PlaceSection
    ) -> PlacedThing:
        released, removed = presentation.released_after, presentation.removed_after
        until = math.inf if released is None else released
        return PlacedThing(
            item,
            held_until=until if place.held else None,
            removed=math.inf if removed is None else removed,
            returned_after=presentation.returned_after,
            movement=None if presentation.motion is None else self._movement(presentation.motion),
            from_turn=presentation.from_turn,
            scattered=presentation.scattered,
            displaced=presentation.displaced,
        )

    def _pose(
        self, place: PlaceSection, half_height: float, known: Mapping[str, SceneObject]
    ) -> Pose:
        # The order of draws is fixed, because a seed determines a scene by it.
        x, y = self._across(place, known)
        turned = Pose.turned(_UP, draw(place.yaw, self._rng))
        if place.pitch != (0.0, 0.0):  # drawn only if it is left to chance
            turned = turned @ Pose.turned(_ACROSS, draw(place.pitch, self._rng))
        if place.gap is not None:
            z = draw(place.gap, self._rng) + half_height
        elif place.z is not None:
            z = draw(place.z, self._rng)
        elif place.on is not None:
            floor = self._named(known, place.on, "fixture")
            above = floor.shape.half_height
            # A support whose place is drawn carries the object in its own frame.
            if place.beside is None and self._is_drawn(place.on):
                place_on_it = np.array([x, y, above + half_height])
                return floor.pose @ Pose(place_on_it, turned.rotation)
            z = float(floor.pose.position[2]) + above + half_height
        else:
            lower = self._beside(place, known)
            # Beside an object and without a height: on the same floor as that object.
            z = float(lower.pose.position[2]) - lower.shape.half_height + half_height
        pose = Pose(np.array([x, y, z]), turned.rotation)
        return pose if place.hand is None else self._tip(place.hand) @ pose

    def _is_drawn(self, name: str) -> bool:
        """Return whether the place of an object is drawn."""
        return name not in self._stage.fixtures or self._stage.fixtures[name].is_drawn

    def _across(self, place: PlaceSection, known: Mapping[str, SceneObject]) -> tuple[float, float]:
        """Return the coordinates of a place along x and y."""
        if place.beside is None:
            return draw(place.x, self._rng), draw(place.y, self._rng)
        x, y, _ = self._beside(place, known).pose.position.tolist()
        distance = draw(place.beside.by, self._rng)
        direction = draw(place.beside.direction, self._rng)
        return x + distance * math.cos(direction), y + distance * math.sin(direction)

    def _beside(self, place: PlaceSection, known: Mapping[str, SceneObject]) -> SceneObject:
        """Return the object that a place is beside."""
        assert place.beside is not None, "only such places are asked about"
        return self._named(known, place.beside.name, "fixture or placed thing")

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
        within = math.inf if motion.within is None else motion.within
        return Movement(velocity, start, motion.thrown, within)

    def _named(self, entries: Mapping[str, _Entry], name: str, kind: str) -> _Entry:
        if name not in entries:
            known = ", ".join(entries) or "none"
            raise BackendError(
                f"stage '{self._stage.name}' names the {kind} '{name}'; there is: {known}"
            )
        return entries[name]


# Depth by which two objects may each be inside the other, as by rounding in contact, m.
_MARGIN = 5e-4


class Conflict(NamedTuple):
    """Two objects that are too close together; its text is a part of a sentence.

    Attributes:
        one, other: Names of the objects.
        room: Required distance between them, m; 0 if they overlap.
    """

    one: str
    other: str
    room: float

    def __str__(self) -> str:
        if self.room:
            return f"'{self.one}' and '{self.other}' are less than {100 * self.room:g} cm apart"
        return f"'{self.one}' overlaps '{self.other}'"


def find_conflict(
    scenario: Scenario, apart: Mapping[str, float], supports: Mapping[str, str | None]
) -> Conflict | None:
    """Return the first conflict of a scene; ``None`` if there is none.

    Args:
        scenario: Scenario with the scene.
        apart: Required distance of each thing from all others, by name, m.
        supports: Support that each thing stands on, by name; the two may be close.
    """
    for one, other in _pairs(scenario):
        rooms = [apart.get(each.name, 0.0) for each in (one, other) if one.mass and other.mass]
        stacked = supports.get(one.name) == other.name or supports.get(other.name) == one.name
        room = 0.0 if stacked else max(rooms, default=0.0)
        if _too_close(one, other, room):
            return Conflict(one.name, other.name, room)
    return None


def _pairs(scenario: Scenario) -> Iterator[tuple[SceneObject, SceneObject]]:
    """Yield all pairs of an object with another, or with a fixture."""
    things = [thing.item for thing in scenario.things]
    yield from combinations(things, 2)
    yield from ((thing, fixture) for thing in things for fixture in scenario.fixtures)


def _too_close(one: SceneObject, other: SceneObject, room: float) -> bool:
    bodies = (each.shape.bodies(each.pose) for each in (one, other))
    return any(_close(a, b, room) for a, b in product(*bodies))


def _close(one: Convex, other: Convex, room: float) -> bool:
    way = float(np.linalg.norm(one.position - other.position))
    # The balls around both bodies are apart, which is much faster to find than the gap.
    if way >= one.radius + other.radius + room:
        return False
    if room:
        return gap(one, other) < room
    # An object on a table touches it, and rounding may put it inside.
    return gap(one.shrunk(_MARGIN), other.shrunk(_MARGIN)) == 0.0
