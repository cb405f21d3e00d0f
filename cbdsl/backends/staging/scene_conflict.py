"""Conflicts of a scene: objects that overlap, or are closer together than requested."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations, product
from typing import NamedTuple

import numpy as np

from cbdsl.backends.staging.scenario import Scenario, SceneObject
from cbdsl.numeric.convex import Convex, gap

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
