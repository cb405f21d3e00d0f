"""The experimenter: puts up what an episode shows, and does with the thing what is to be done."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.backends.kinematic.thing import Thing
from cbdsl.backends.kinematic.world import World
from cbdsl.backends.staging.fall import Fall
from cbdsl.backends.staging.presentation import Movement, Presentation


class Experimenter:
    """Acts in the world as a person would beside the robot, and sees all of it.

    Args:
        presentation: what is shown in this episode.
        world: where fixtures and things are put.

    Attributes:
        shown: the thing, until it is taken away.
    """

    def __init__(self, presentation: Presentation, world: World) -> None:
        self._world = world
        self._removal, self._release = presentation.removed, math.inf
        self._movement = presentation.movement
        self._fall: Fall | None = None
        self.shown: Thing | None = None
        for fixture in presentation.fixtures:
            world.add(*fixture)
        if presentation.thing is not None:
            self.shown = world.add(*presentation.thing)
            self._place = presentation.thing.pose
            if presentation.returned_after is not None:
                self._fall = Fall(float(self._place.position[2]), presentation.returned_after)
            if presentation.held_until is not None:
                self.shown.gripped, self._release = True, presentation.held_until

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
        if self._movement is not None:
            self._move(thing, self._movement, time, touched=touched)
        if self._fall and self._fall.is_due(float(thing.position[2]), time, touched=touched):
            thing.put(self._place)
            thing.launch(np.zeros(3))
            thing.rolling[:] = 0.0

    def _move(self, thing: Thing, movement: Movement, time: float, *, touched: bool) -> None:
        due = time >= movement.start
        if movement.thrown:
            if due:
                thing.launch(movement.velocity)
                self._movement = None
        elif touched:
            # What is carried along is left to the hand that touches it.
            thing.gripped, self._movement = False, None
            thing.launch(np.zeros(3))
        elif due and not thing.gripped:
            thing.gripped = True
            thing.launch(movement.velocity)
