"""The checked program: immutable, fully resolved, ready to run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from cbdsl.program.controller import Composition, Primitive


class Action(NamedTuple):
    """An action that a policy can select.

    Attributes:
        name: the action as its program writes it, in canonical spelling.
        composition: the controllers that it runs, or ``None`` where it is a program.
        program: the program that it runs, or ``None`` where it is a composition.
    """

    name: str
    composition: Composition | None = None
    program: CheckedProgram | None = None


class CheckedProgram(NamedTuple):
    """A program without errors, fully resolved.

    Attributes:
        name: the program's name.
        robot: the robot that it was checked for.
        stage: the training context it is used in unless another is named.
        parameters: the values of its parameters.
        members: the controllers and programs of a state's predicates, in order, by name.
        primitives: the members that are primitives, by name.
        actions: the actions that a policy can select.
        policy: action name by state pattern (one of ``X - 0 1 *`` per member).
        background: the composition that runs below every action.
        transitions: most state transitions in an episode.
        transition_time: longest time one action may run without a change of state, s.
        idle_time: the same while no predicate is 0 and no controller seeks what defines it, s;
            ``None`` for no limit but that.
    """

    name: str
    robot: str
    stage: str | None
    parameters: Mapping[str, str]
    members: tuple[str, ...]
    primitives: Mapping[str, Primitive]
    actions: tuple[Action, ...]
    policy: Mapping[str, str]
    background: Composition | None
    transitions: int
    transition_time: float
    idle_time: float | None

    @property
    def sequential_actions(self) -> tuple[Action, ...]:
        """The actions of a single member, without co-articulation (Section 4.2.1)."""
        return tuple(action for action in self.actions if action.name in self.members)
