"""Experimenter: sets up the scene of an episode, and performs its scripted actions."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cbdsl.backends.staging.engine import Engine
from cbdsl.backends.staging.sampler import ScenarioSampler
from cbdsl.backends.staging.scenario import PlacedThing, Scenario
from cbdsl.backends.staging.scripted_action import (
    FALLEN,
    CarryAction,
    HoldAction,
    ReturnAction,
    ScriptedAction,
    ThrowAction,
)
from cbdsl.documents.context import Context
from cbdsl.documents.stage import WorldSection
from cbdsl.kinematics.pose import Pose

# Distance from its place beyond which an object counts as moved, m.
_MOVED = 0.02


class _Plan:
    """All actions of the experimenter on one object.

    Args:
        thing: Object, already in the world.
        engine: Engine with the object.
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
        """Act at a time since the episode began, s.

        Returns:
            Whether no action is left.
        """
        # Removal precedes all actions, which need the object in the world.
        if time >= self._removal:
            self._engine.remove(self._name)
            return True
        self._actions = [action for action in self._actions if not action.act(time)]
        return not self._actions and self._removal == math.inf


class Experimenter:
    """Agent that acts in the world like a person beside the robot, and knows its whole state.

    Args:
        sampler: Sampler of the episode's scene, and of new places.
        context: Context of the scene.
        engine: Engine with the world.
    """

    def __init__(self, sampler: ScenarioSampler, context: Context, engine: Engine) -> None:
        self._sampler, self._context, self._engine = sampler, context, engine
        # All objects are drawn in advance, so that those of later turns have room.
        self._scenario = sampler.sample(context)
        self._turn = 0
        for item in self._scenario.fixtures:
            engine.add(item)
        self._plans: list[_Plan] = []
        self._places: dict[str, Pose] = {}
        self._bring()

    def act(self, time: float) -> None:
        """Act at a time since the episode began, s."""
        self._plans = [plan for plan in self._plans if not plan.act(time)]

    def take_turn(self, world: WorldSection) -> None:
        """Bring, move and put back objects between two episodes of a persistent world."""
        self._turn += 1
        self._bring()
        for thing in self._scenario.things:
            name = thing.item.name
            if name in self._places and name in self._engine.objects:
                self._displace(thing)
                self._tidy(thing, world)

    def _bring(self) -> None:
        """Add the objects whose turn has come."""
        for thing in self._scenario.things:
            if thing.from_turn == self._turn:
                self._engine.add(thing.item)
                self._plans.append(_Plan(thing, self._engine))
                self._places[thing.item.name] = thing.item.pose

    def _displace(self, thing: PlacedThing) -> None:
        """Move an object permanently, as its script says."""
        for move in thing.displaced:
            if move.turn == self._turn:
                home = self._places[thing.item.name]
                moved = Pose(home.position + np.array(move.by), home.rotation)
                self._places[thing.item.name] = moved
                self._engine.put_back(thing.item.name, moved)

    def _tidy(self, thing: PlacedThing, world: WorldSection) -> None:
        """Put an object back at its place, unless the robot touches it or is in the way."""
        name = thing.item.name
        # An object in a hand is left to the robot.
        if self._engine.touched(name):
            return
        home = self._places[name]
        if thing.scattered is not None:
            place = self._sampler.scatter(self._context, self._now(), name, home)
        elif not self._is_astray(name, home, world):
            return
        elif world.where == "anew":
            place = self._sampler.place_again(self._context, self._now(), name)
            self._places[name] = place or home
        else:
            place = home
        self._engine.put_back(name, place or home)

    def _is_astray(self, name: str, home: Pose, world: WorldSection) -> bool:
        """Return whether an object is at a place where the experimenter does not leave it."""
        way = self._engine.pose(name).position - home.position
        fallen = world.put_back != "nothing" and float(way[2]) <= -FALLEN
        return fallen or (world.put_back == "moved" and math.hypot(*way.tolist()) >= _MOVED)

    def _now(self) -> Scenario:
        """Return the current scene."""
        things = tuple(
            replace(thing, item=thing.item._replace(pose=self._engine.pose(thing.item.name)))
            for thing in self._scenario.things
            if thing.item.name in self._engine.objects
        )
        return Scenario(self._scenario.fixtures, things)
