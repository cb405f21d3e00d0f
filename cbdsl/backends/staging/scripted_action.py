"""Scripted actions: the experimenter's actions on an object while an episode runs."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from cbdsl.backends.staging.engine import Engine
from cbdsl.backends.staging.scenario import Movement
from cbdsl.numeric.arrays import Floats

#: Depth below its place at which an object counts as fallen, m.
FALLEN = 0.2


class Fall:
    """One object that may fall from its place repeatedly.

    Args:
        height: Height of its place, m.
        delay: Delay after which it is put back, s.
    """

    def __init__(self, height: float, delay: float) -> None:
        self._lowest, self._delay = height - FALLEN, delay
        self._began = math.inf

    def is_due(self, height: float, time: float, *, touched: bool) -> bool:
        """Return whether it is time to put the object back.

        Args:
            height: Current height, m.
            time: Time since the episode began, s.
            touched: True if the robot touches the object; a carried object has not fallen.
        """
        if height > self._lowest or touched:
            self._began = math.inf
            return False
        self._began = min(self._began, time)
        return time - self._began >= self._delay


class ScriptedAction(Protocol):
    """Action that continues in every physics step until it is finished."""

    def act(self, time: float) -> bool:
        """Act at a time since the episode began, s.

        Returns:
            Whether it is finished.
        """
        ...


class HoldAction:
    """Action that holds an object still against any force until a time, s."""

    def __init__(self, engine: Engine, name: str, until: float) -> None:
        self._engine, self._name, self._until = engine, name, until
        engine.attach(name)

    def act(self, time: float) -> bool:
        """Release the object when it is time."""
        over = time >= self._until
        if over:
            self._engine.release(self._name)
        return over


class CarryAction:
    """Action that carries or shakes an object until the robot touches it."""

    def __init__(self, engine: Engine, name: str, movement: Movement) -> None:
        self._engine, self._name = engine, name
        self._movement, self._start = movement, movement.start
        self._carries, self._before = False, math.nan

    def act(self, time: float) -> bool:
        """Lead the object on, or release it to the hand that touches it."""
        if self._engine.touched(self._name):
            self._engine.release(self._name)
            return True
        # The motion starts where the object is then, which may be after a fall onto its fixture.
        if not self._carries and time >= self._start:
            self._engine.attach(self._name)
            self._carries = True
            self._origin, self._start = self._engine.pose(self._name).position, time
        if self._carries:
            position = self._origin + _way(self._movement, time - self._start)
            self._engine.lead(self._name, position, self._velocity(time))
        self._before = time
        return False

    def _velocity(self, time: float) -> Floats:
        """Return the velocity that takes the object to its place after the next step, m/s."""
        step = time - self._before
        # The step is not a number in the first call.
        if math.isinf(self._movement.within) or not step > 0.0:
            return self._movement.velocity
        # The difference of places, unlike the derivative, leaves no drift over finite steps.
        next_place = self._origin + _way(self._movement, time + step - self._start)
        velocity: Floats = (next_place - self._engine.pose(self._name).position) / step
        return velocity


def _way(movement: Movement, time: float) -> Floats:
    """Return the displacement of a led object from its origin after a time, s."""
    speed = float(np.linalg.norm(movement.velocity))
    if math.isinf(movement.within) or speed == 0.0:
        return time * movement.velocity
    # Harmonic motion x = a sin(v t / a), whose largest speed is v.
    way: Floats = math.sin(speed / movement.within * time) * movement.within * movement.velocity
    return way / speed


class ThrowAction:
    """Action that gives an object a velocity once."""

    def __init__(self, engine: Engine, name: str, movement: Movement) -> None:
        self._engine, self._name, self._movement = engine, name, movement

    def act(self, time: float) -> bool:
        """Throw the object, once its time has come."""
        due = time >= self._movement.start
        if due:
            self._engine.launch(self._name, np.array(self._movement.velocity))
        return due


class ReturnAction:
    """Action that puts an object back at its place, a while after it fell from there."""

    def __init__(self, engine: Engine, name: str, delay: float) -> None:
        self._engine, self._name = engine, name
        self._place = engine.pose(name)
        self._fall = Fall(float(self._place.position[2]), delay)

    def act(self, time: float) -> bool:
        """Put the object back when it is time, as soon as the robot is not in the way."""
        touched = self._engine.touched(self._name)
        height = float(self._engine.pose(self._name).position[2])
        if self._fall.is_due(height, time, touched=touched):
            self._engine.put_back(self._name, self._place)
        return False
