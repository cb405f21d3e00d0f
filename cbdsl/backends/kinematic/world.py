"""The world besides the robot: things that stand, roll, fall, and go along with hands."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.kinematic.kinematic_object import KinematicObject
from cbdsl.backends.staging.scenario import GRAVITY, SceneObject
from cbdsl.backends.staging.shape import Wall
from cbdsl.backends.staging.solids import WIDTH, Walls

Floats = NDArray[np.float64]

# What is this near to a floor stands on it, m.
_CLOSE = 1e-3
# What has sunk further than this below a top is beside it, m.
_BESIDE = 0.02
# Nothing goes along with the only thing that can be moved.
_ALONE = nullcontext()


class World:
    """Things in one episode, moved without forces: they stay upright where they fall and roll.

    Attributes:
        objects: fixtures and things by name, as the stage has them.
        things: the same, as they move.
        solids: all of them in that order, as ``solids`` has them, shape (k, 16); another array
            when something comes or goes.
        walls: the solids that they are made of.
    """

    def __init__(self) -> None:
        self.objects: dict[str, SceneObject] = {}
        self.things: dict[str, KinematicObject] = {}
        self.solids: Floats = np.empty((0, WIDTH))
        self.walls = Walls([])

    def add(self, item: SceneObject) -> KinematicObject:
        """Put something there; without mass it does not move."""
        thing = self.things[item.name] = KinematicObject(item)
        self.objects[item.name] = item
        self._gather()
        return thing

    def remove(self, name: str) -> None:
        """Take something out of the world; what stood on it falls."""
        for rider in self._riders(self.things[name]):
            rider.resting = False
        del self.things[name], self.objects[name]
        self._gather()

    def taking_along(self, thing: KinematicObject) -> AbstractContextManager[None]:
        """Let what stands on a thing, and on that, go along while it is moved."""
        return _ALONE if self._movable < 2 else self._taking_along(thing)

    @contextmanager
    def _taking_along(self, thing: KinematicObject) -> Iterator[None]:
        riders, before = list(self._riders(thing)), thing.position.copy()
        yield
        shift = thing.position - before
        if shift.any():
            for rider in riders:
                rider.shift(shift)

    def _riders(self, thing: KinematicObject) -> Iterator[KinematicObject]:
        """All that stands on a thing and is not held, and on that."""
        for other in self.things.values():
            if other.mass and not other.gripped and other is not thing:
                top = _top(thing, other)
                if top is not None and abs(other.bottom - top) < _CLOSE:
                    yield other
                    yield from self._riders(other)

    def _gather(self) -> None:
        """Let all things keep their poses in one array."""
        self.walls = Walls([thing.shape for thing in self.things.values()])
        self._movable = sum(thing.mass > 0.0 for thing in self.things.values())
        self.solids = np.array([thing.solid for thing in self.things.values()])
        self.solids = self.solids.reshape(len(self.things), WIDTH)
        for thing, solid in zip(self.things.values(), self.solids, strict=True):
            thing.solid = solid

    def let_go(self, thing: KinematicObject, period: float) -> None:
        """Let something that nobody holds move for ``period``, s."""
        if thing.resting:
            return
        floor = self.floor(thing)
        if floor is not None and thing.velocity[2] <= 0.0:
            self._glide(thing, floor, period)
            return
        # By the mean velocity, which makes it a parabola however long the period is.
        thing.velocity[2] -= 0.5 * GRAVITY * period
        thing.shift(period * thing.velocity)
        fallen = -period * float(thing.velocity[2])
        thing.velocity[2] -= 0.5 * GRAVITY * period
        self.land(thing, fallen)

    def land(self, thing: KinematicObject, fallen: float = 0.0) -> None:
        """Lift what has sunk into the top of something, or fallen through it just now, onto it.

        Args:
            thing: what may have landed.
            fallen: how far it has just fallen, m.
        """
        bottom, deepest = thing.bottom, _BESIDE + max(fallen, 0.0)
        tops = [_top(lower, thing) for lower in self.things.values()]
        depths = [top - bottom for top in tops if top is not None]
        sunk = max((depth for depth in depths if depth < deepest), default=0.0)
        if sunk > 0.0:
            thing.shift(np.array([0.0, 0.0, sunk]))
            thing.velocity[2] = 0.0

    def floor(self, thing: KinematicObject) -> KinematicObject | None:
        """The fixture or thing that something stands on, if any."""
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
            velocity *= max(speed - slower, 0.0) / max(speed, _CLOSE * slower)
        thing.shift(period * thing.velocity)


def _spin(ball: KinematicObject, change: float) -> None:
    """Let friction slow a sliding ball by at most ``change``, m/s, and spin it, until it rolls."""
    slip = ball.velocity - ball.rolling
    size = math.hypot(*slip.tolist())
    if size == 0.0:
        return
    # A ball's inertia is two fifths of its mass: it spins up faster than it slows down.
    lost = min(change, size / 3.5) / size * slip
    ball.velocity -= lost
    ball.rolling += 2.5 * lost


def _top(lower: KinematicObject, thing: KinematicObject) -> float | None:
    """Height of the top of something under the middle of a thing, m, ``None`` where not under."""
    if lower is thing:
        return None
    _, _, _, _, a, b, c, xx, yx, _, xy, yy, _, xz, yz, _ = lower.solid.tolist()
    u, v, w = thing.position.tolist()
    u, v, w = u - a, v - b, w - c
    x, y = u * xx + v * xy + w * xz, u * yx + v * yy + w * yz
    if lower.shape.walls:
        # Of something hollow that stands upright, the highest wall under it.
        tops = (_wall_top(wall, x, y) for wall in lower.shape.walls)
        height = max((top for top in tops if top is not None), default=None)
        return None if height is None else float(lower.solid[6]) + height
    a, b, _ = lower.shape.halves
    kind = lower.shape.kind
    if kind == "ball":
        level = a * a - x * x - y * y
        return float(lower.solid[6]) + math.sqrt(level) if level > 0 else None
    inside = math.hypot(x, y) < a if kind == "cylinder" else abs(x) < a and abs(y) < b
    return lower.top if inside else None


def _wall_top(wall: Wall, x: float, y: float) -> float | None:
    """Height of a wall's top over the middle of what it is a wall of, m, if (x, y) is over it."""
    (dx, dy, dz), turn = wall.origin.xyz, wall.origin.rpy[2]
    u = math.cos(turn) * (x - dx) + math.sin(turn) * (y - dy)
    v = math.cos(turn) * (y - dy) - math.sin(turn) * (x - dx)
    a, b, c = wall.shape.halves
    return dz + c if abs(u) < a and abs(v) < b else None
