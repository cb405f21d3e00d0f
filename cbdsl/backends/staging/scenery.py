"""What a backend shows of its world to the experimenter's recordings, and to no controller."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Part(NamedTuple):
    """A shape that a body is made of.

    Attributes:
        shape: ``ball`` (radius), ``box`` (edge lengths) or ``cylinder`` about z (radius, height).
        size: as the shape needs it, m.
        position: of its centre in the body's frame, m.
        quaternion: of its axes in the body's frame, as (x, y, z, w).
        color: red, green and blue, each from 0 to 1.
    """

    shape: str
    size: tuple[float, ...]
    position: tuple[float, ...]
    quaternion: tuple[float, ...]
    color: tuple[float, ...]


class Placed(Protocol):
    """Where a body is in the world."""

    @property
    def position(self) -> Floats:
        """Of its frame's origin, m, shape (3,)."""
        ...

    def quaternion(self) -> tuple[float, float, float, float]:
        """Of its axes, as (x, y, z, w)."""
        ...


class Scenery(Protocol):
    """The bodies besides the robot that are in the world now."""

    def names(self) -> tuple[str, ...]:
        """What the stage has put into the world and not taken away."""
        ...

    def parts(self, name: str) -> Sequence[Part]:
        """What a body looks like."""
        ...

    def pose(self, name: str) -> Placed:
        """Where a body is."""
        ...


@runtime_checkable
class Witness(Protocol):
    """A backend that knows its world; another one for every episode.

    Attributes:
        truth: the world of this episode.
    """

    @property
    def truth(self) -> Scenery:
        """The world of this episode."""
        ...
