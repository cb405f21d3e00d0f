"""Scenario of an episode: objects, places and scripted events."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from cbdsl.backends.staging.shape import SolidShape
from cbdsl.documents.context import Displacement, Scatter
from cbdsl.documents.stage import Surface
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.arrays import Floats

#: Acceleration of falling things, m/s^2.
GRAVITY = 9.81


class SceneObject(NamedTuple):
    """Fixture or thing of a stage, as it is added to the world.

    Attributes:
        name: Unique name in the world.
        shape: Shape of definite size.
        surface: Colour and friction.
        mass: Mass, kg; 0 for a fixture.
        pose: Pose of its centre.
    """

    name: str
    shape: SolidShape
    surface: Surface
    mass: float
    pose: Pose


class Movement(NamedTuple):
    """Motion of a thing that the experimenter carries along, shakes or throws.

    Attributes:
        velocity: Velocity, m/s, shape (3,); level unless it is thrown; at the middle if it is
            shaken.
        start: Time since the episode began, s.
        thrown: True if the velocity is given once, instead of kept.
        within: Amplitude to either side if it is shaken, m; infinite if it moves straight on.
    """

    velocity: Floats
    start: float
    thrown: bool
    within: float = math.inf


@dataclass(frozen=True)
class PlacedThing:
    """Thing in a scene, and its scripted events; times are since the episode began, s.

    Attributes:
        item: Thing in its place.
        held_until: Time at which the experimenter releases it; ``None`` if it is not held.
        removed: Time at which it is removed.
        returned_after: Time from its fall until it is put back; ``None`` if it is not.
        movement: Motion; ``None`` if it is not moved.
        from_turn: Turn of the experimenter in which it is added.
        scattered: Random displacement in each turn; ``None`` for none.
        displaced: Displacements in single turns.
    """

    item: SceneObject
    held_until: float | None = None
    removed: float = math.inf
    returned_after: float | None = None
    movement: Movement | None = None
    from_turn: int = 0
    scattered: Scatter | None = None
    displaced: tuple[Displacement, ...] = ()


@dataclass(frozen=True)
class Scenario:
    """Objects and events of one episode.

    Attributes:
        fixtures: Objects that do not move.
        things: Other objects of the scene.
    """

    fixtures: tuple[SceneObject, ...]
    things: tuple[PlacedThing, ...] = ()
