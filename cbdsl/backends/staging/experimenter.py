"""The experimenter: puts up what an episode shows, and carries out its scripted actions."""

from __future__ import annotations

import math
from typing import Literal

from cbdsl.backends.staging.engine import Engine
from cbdsl.backends.staging.fall import FALLEN
from cbdsl.backends.staging.scenario import PlacedThing, Scenario
from cbdsl.backends.staging.scripted_action import (
    CarryAction,
    HoldAction,
    ReturnAction,
    ScriptedAction,
    ThrowAction,
)

# What is this far from where it was put has moved, m.
_MOVED = 0.02


class _Plan:
    """All that the experimenter does with one thing.

    Args:
        thing: in the world already.
        engine: that it is in.
    """

    def __init__(self, thing: PlacedThing, engine: Engine) -> None:
        self._engine, self._name, self._removal = engine, thing.item.name, thing.removed
        self._actions: list[ScriptedAction] = []
        if thing.held_until is not None:
            self._actions.append(HoldAction(engine, self._name, thing.held_until))
        if thing.movement is not None:
            action = ThrowAction if thing.movement.thrown else CarryAction
            self._actions.append(action(engine, self._name, thing.movement))
        if thing.returned_after is not None:
            self._actions.append(ReturnAction(engine, self._name, thing.returned_after))

    def act(self, time: float) -> bool:
        """Act at this time since the episode began, s.

        Returns:
            Whether there is nothing left to do.
        """
        if time >= self._removal:
            self._engine.remove(self._name)
            return True
        self._actions = [action for action in self._actions if not action.act(time)]
        return not self._actions and self._removal == math.inf


class Experimenter:
    """Acts in the world as a person would beside the robot, and sees all of it.

    Args:
        scenario: what is shown in this episode.
        engine: where it is put.
    """

    def __init__(self, scenario: Scenario, engine: Engine) -> None:
        for item in (*scenario.fixtures, *(thing.item for thing in scenario.things)):
            engine.add(item)
        self._engine = engine
        self._places = {thing.item.name: thing.item.pose for thing in scenario.things}
        self._plans = [_Plan(thing, engine) for thing in scenario.things]

    def act(self, time: float) -> None:
        """Act at this time since the episode began, s."""
        self._plans = [plan for plan in self._plans if not plan.act(time)]

    def tidy(self, which: Literal["nothing", "fallen", "moved"]) -> None:
        """Put things where they were at first, unless the robot touches them or is in the way."""
        for name, place in self._places.items():
            if name not in self._engine.objects or self._engine.touched(name):
                continue
            way = self._engine.pose(name).position - place.position
            fallen = which != "nothing" and float(way[2]) <= -FALLEN
            if fallen or (which == "moved" and math.hypot(*way.tolist()) >= _MOVED):
                self._engine.put_back(name, place)
