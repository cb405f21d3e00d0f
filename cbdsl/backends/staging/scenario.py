"""Scenario of an episode: what is shown, where, and what is done with it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.staging.pose import Pose
from cbdsl.backends.staging.shape import SolidShape
from cbdsl.documents.context import Displacement, Scatter
from cbdsl.documents.stage import Surface

Floats = NDArray[np.float64]

#: Acceleration of falling things, m/s^2.
GRAVITY = 9.81


class SceneObject(NamedTuple):
    """A fixture or thing of a stage, as it is put into the world.

    Attributes:
        name: that it has in the world, unlike all others.
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
    """Motion of a thing that the experimenter carries along, shakes or throws.

    Attributes:
        velocity: m/s, shape (3,); level unless it is thrown. Of what is shaken, in the middle.
        start: since the episode began, s.
        thrown: whether it is given its velocity once, instead of kept at it.
        within: how far to either side it is shaken, m; infinite where it goes straight on.
    """

    velocity: Floats
    start: float
    thrown: bool
    within: float = math.inf


@dataclass(frozen=True)
class PlacedThing:
    """A thing that is shown, and the events that befall it; times are since the episode began, s.

    Attributes:
        item: the thing in its place.
        held_until: when the experimenter lets go of it, ``None`` if nobody holds it.
        removed: when it is taken away.
        returned_after: how long after it has fallen it is put back, ``None`` if nobody does that.
        movement: how it is moved, if it is.
        from_turn: turn of the experimenter in which it comes.
        scattered: how it is moved in each turn, if it is.
        displaced: moves in single turns.
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
        fixtures: objects that do not move.
        things: the objects that are shown besides.
    """

    fixtures: tuple[SceneObject, ...]
    things: tuple[PlacedThing, ...] = ()
