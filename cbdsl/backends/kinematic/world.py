"""World besides the robot: objects that stand, roll, fall, and move with hands."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext

import numpy as np

from cbdsl.backends.kinematic.kinematic_object import KinematicObject
from cbdsl.backends.staging.scenario import GRAVITY, SceneObject
from cbdsl.backends.staging.shape import Wall
from cbdsl.backends.staging.solids import WIDTH, Walls
from cbdsl.numeric.arrays import Floats

# Distance to a floor within which an object stands on it, m.
_CLOSE = 1e-3
# Depth below a top beyond which an object is beside it, m.
_BESIDE = 0.02
# If only one object is movable, no other moves with it.
_ALONE = nullcontext()


class World:
    """Objects in one episode, moved without forces: they stay upright when they fall and roll.

    Attributes:
        objects: Fixtures and things by name, as in the stage.
        things: The same objects, with their motion.
        solids: Rows of all objects in that order, as in ``solids``, shape (k, 16); another array
            after an object is added or removed.
        walls: Solids that the objects consist of.
    """

    def __init__(self) -> None:
        self.objects: dict[str, SceneObject] = {}
        self.things: dict[str, KinematicObject] = {}
        self.solids: Floats = np.empty((0, WIDTH))
        self.walls = Walls([])

    def add(self, item: SceneObject) -> KinematicObject:
        """Add an object; without mass it does not move."""
        thing = self.things[item.name] = KinematicObject(item)
        self.objects[item.name] = item
        self._gather()
        return thing

    def remove(self, name: str) -> None:
        """Remove an object; objects that stood on it fall."""
        for rider in self._riders(self.things[name]):
            rider.resting = False
        del self.things[name], self.objects[name]
        self._gather()

    def taking_along(self, thing: KinematicObject) -> AbstractContextManager[None]:
        """Return a context in which objects on an object, directly or not, move with it."""
        return _ALONE if self._movable < 2 else self._taking_along(thing)

    @contextmanager
    def _taking_along(self, thing: KinematicObject) -> Iterator[None]:
        # Riders are found before the motion, while they still stand on the object.
        riders, before = list(self._riders(thing)), thing.position.copy()
        yield
        shift = thing.position - before
        if shift.any():
            for rider in riders:
                rider.shift(shift)

    def _riders(self, thing: KinematicObject) -> Iterator[KinematicObject]:
        """Yield all objects that rest on an object, directly or not, and are not held."""
        for other in self.things.values():
            if other.mass and not other.gripped and other is not thing:
                top = _top(thing, other)
                if top is not None and abs(other.bottom - top) < _CLOSE:
                    yield other
                    yield from self._riders(other)

    def _gather(self) -> None:
        """Store the poses of all objects in one array."""
        self.walls = Walls([thing.shape for thing in self.things.values()])
        self._movable = sum(thing.mass > 0.0 for thing in self.things.values())
        self.solids = np.array([thing.solid for thing in self.things.values()])
        self.solids = self.solids.reshape(len(self.things), WIDTH)
        for thing, solid in zip(self.things.values(), self.solids, strict=True):
            thing.solid = solid

    def let_go(self, thing: KinematicObject, period: float) -> None:
        """Advance the motion of a free object by ``period``, s."""
        if thing.resting:
            return
        floor = self.floor(thing)
        if floor is not None and thing.velocity[2] <= 0.0:
            self._glide(thing, floor, period)
            return
        # The mean velocity gives a parabola for any period.
        thing.velocity[2] -= 0.5 * GRAVITY * period
        thing.shift(period * thing.velocity)
        fallen = -period * float(thing.velocity[2])
        thing.velocity[2] -= 0.5 * GRAVITY * period
        self.land(thing, fallen)

    def land(self, thing: KinematicObject, fallen: float = 0.0) -> None:
        """Lift an object that has sunk into a top, or has just fallen through it, onto that top.

        Args:
            thing: Object that may have landed.
            fallen: Distance that it has just fallen, m.
        """
        # A fast object passes a thin top within a tick. Tops within the way of its fall still stop
        # it.
        bottom, deepest = thing.bottom, _BESIDE + max(fallen, 0.0)
        tops = [_top(lower, thing) for lower in self.things.values()]
        depths = [top - bottom for top in tops if top is not None]
        sunk = max((depth for depth in depths if depth < deepest), default=0.0)
        if sunk > 0.0:
            thing.shift(np.array([0.0, 0.0, sunk]))
            thing.velocity[2] = 0.0

    def floor(self, thing: KinematicObject) -> KinematicObject | None:
        """Return the fixture or object that an object stands on; ``None`` if there is none."""
        bottom = thing.bottom
        for lower in self.things.values():
            top = _top(lower, thing)
            if top is not None and abs(bottom - top) < _CLOSE:
                return lower
        return None

    @staticmethod
    def _glide(thing: KinematicObject, floor: KinematicObject, period: float) -> None:
        """Roll or slide over a level floor for ``period``, s."""
        thing.velocity[2] = thing.rolling[2] = 0.0
        if not (thing.velocity.any() or thing.rolling.any()):
            thing.resting = True
            return
        if thing.rolls:
            _spin(thing, period * thing.sliding_friction(floor))
        slower = period * thing.resistance(floor)
        for velocity in (thing.velocity, thing.rolling):
            speed = math.hypot(*velocity.tolist())
            # Without friction, both speed and resistance may be 0.
            if speed > 0.0:
                velocity *= max(speed - slower, 0.0) / speed
        thing.shift(period * thing.velocity)


def _spin(ball: KinematicObject, change: float) -> None:
    """Slow a sliding ball by friction, by at most ``change``, m/s, and spin it until it rolls."""
    # Friction with the floor changes the velocity of the centre by -a, and that of the rim by a m
    # r^2 / I = 5/2 a. So the slip closes by 7/2 a, and a ball that only slides at first rolls on
    # with 5/7 of its speed.
    slip = ball.velocity - ball.rolling
    size = math.hypot(*slip.tolist())
    if size == 0.0:
        return
    # A ball's inertia is two fifths of its mass: it spins up faster than it slows down.
    lost = min(change, size / 3.5) / size * slip
    ball.velocity -= lost
    ball.rolling += 2.5 * lost


def _top(lower: KinematicObject, thing: KinematicObject) -> float | None:
    """Return an object's height under the middle of another, m; ``None`` if it is beside it."""
    if lower is thing:
        return None
    _, _, _, _, a, b, c, xx, yx, _, xy, yy, _, xz, yz, _ = lower.solid.tolist()
    u, v, w = thing.position.tolist()
    u, v, w = u - a, v - b, w - c
    x, y = u * xx + v * xy + w * xz, u * yx + v * yy + w * yz
    if lower.shape.walls:
        # The highest wall under the middle counts for a hollow object that stands upright.
        tops = (_wall_top(wall, x, y) for wall in lower.shape.walls)
        height = max((top for top in tops if top is not None), default=None)
        return None if height is None else float(lower.solid[6]) + height
    a, b, _ = lower.shape.halves
    kind = lower.shape.kind
    if kind == "ball":
        # The top of a ball is its surface over the point, not its highest point.
        level = a * a - x * x - y * y
        return float(lower.solid[6]) + math.sqrt(level) if level > 0 else None
    inside = math.hypot(x, y) < a if kind == "cylinder" else abs(x) < a and abs(y) < b
    return lower.top if inside else None


def _wall_top(wall: Wall, x: float, y: float) -> float | None:
    """Return the height of a wall's top above its object's middle, m, if (x, y) is over it."""
    (dx, dy, dz), turn = wall.origin.xyz, wall.origin.rpy[2]
    u = math.cos(turn) * (x - dx) + math.sin(turn) * (y - dy)
    v = math.cos(turn) * (y - dy) - math.sin(turn) * (x - dx)
    a, b, c = wall.shape.halves
    return dz + c if abs(u) < a and abs(v) < b else None
