"""The true state of the world. The experimenter and tests may ask; no observation tells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.ideal_cameras.tree import Tree
from cbdsl.backends.kinematic.handling import Handling
from cbdsl.backends.kinematic.hands import Contact
from cbdsl.backends.kinematic.world import World
from cbdsl.backends.staging.pose import Pose
from cbdsl.backends.staging.scenery import Part
from cbdsl.backends.staging.shape import Shape

Floats = NDArray[np.float64]

_ORIGIN, _UNTURNED = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)


class Truth:
    """The true state of the world in one episode."""

    def __init__(self, world: World, tree: Tree, handling: Handling) -> None:
        self._world = world
        self._tree = tree
        self._handling = handling

    @property
    def contacts(self) -> list[Contact]:
        """Of all fingertips, as of the last step."""
        return self._handling.contacts

    def names(self) -> tuple[str, ...]:
        """What the stage has put into the world and not taken away."""
        return tuple(self._world.things)

    def pose(self, name: str) -> Pose:
        """Where a fixture or thing is: its centre and axes."""
        return self._world.things[name].pose

    def parts(self, name: str) -> list[Part]:
        """The shapes that a fixture or thing is made of."""
        thing = self._world.things[name]
        shape, surface = thing.shape, thing.surface
        return [Part(shape.kind, _size(shape), _ORIGIN, _UNTURNED, surface.color)]

    def velocity(self, name: str) -> Floats:
        """Velocity of a thing's centre while nothing holds it, m/s, shape (3,)."""
        return self._world.things[name].velocity.copy()

    def link_pose(self, link: str) -> Pose:
        """Where a link of the robot is."""
        pose = self._tree.pose(link)
        return Pose(pose.position.copy(), pose.rotation.copy())

    def touched(self, name: str) -> bool:
        """Whether any fingertip touches a fixture or thing."""
        return any(contact.thing.name == name for contact in self.contacts)


def _size(shape: Shape) -> tuple[float, ...]:
    """As ``Part`` gives sizes."""
    a, b, c = shape.halves
    if shape.kind == "ball":
        return (a,)
    return (2 * a, 2 * b, 2 * c) if shape.kind == "box" else (a, 2 * c)
