"""The experimenter: puts up what an episode shows, and carries out its scripted actions."""

from __future__ import annotations

from collections.abc import Iterator

from cbdsl.backends.staging.engine import Engine
from cbdsl.backends.staging.scenario import Scenario
from cbdsl.backends.staging.scripted_action import (
    CarryAction,
    HoldAction,
    ReturnAction,
    ScriptedAction,
    ThrowAction,
)


class Experimenter:
    """Acts in the world as a person would beside the robot, and sees all of it.

    Args:
        scenario: what is shown in this episode.
        engine: where it is put.
    """

    def __init__(self, scenario: Scenario, engine: Engine) -> None:
        self._engine = engine
        self._shown: str | None = None
        self._removal = scenario.removed
        self._actions: list[ScriptedAction] = []
        for fixture in scenario.fixtures:
            engine.add(fixture)
        if scenario.thing is not None:
            engine.add(scenario.thing)
            self._shown = scenario.thing.name
            self._actions = list(self._planned(scenario, self._shown))

    def _planned(self, scenario: Scenario, name: str) -> Iterator[ScriptedAction]:
        if scenario.held_until is not None:
            yield HoldAction(self._engine, name, scenario.held_until)
        if scenario.movement is not None:
            action = ThrowAction if scenario.movement.thrown else CarryAction
            yield action(self._engine, name, scenario.movement)
        if scenario.returned_after is not None:
            yield ReturnAction(self._engine, name, scenario.returned_after)

    def act(self, time: float) -> None:
        """Act at this time since the episode began, s."""
        if self._shown is not None and time >= self._removal:
            self._engine.remove(self._shown)
            self._shown, self._actions = None, []
        self._actions = [action for action in self._actions if not action.act(time)]
