"""The checked program: immutable, fully resolved, ready to run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from cbdsl.program.controller import Composition, Controller, Primitive
from cbdsl.program.schema import Schema


class Action(NamedTuple):
    """An action that a policy can select.

    Attributes:
        name: the action as its program writes it, in canonical spelling.
        composition: the controllers that it runs, or ``None`` where it is a program.
        program: the program that it runs, or ``None`` where it is a composition. Where it has
            both, the program is in the place of a member of that composition.
        abstract: the action that it is one allocation of, as its program writes it; in a schema.
        allocation: name of that allocation; empty where no allocation changes the action.
        member: that its program is in the place of, in a composition; empty in all other cases.
        above: how many controllers of the composition have priority over that program.
        background: what runs below it under its allocation; ``None`` for that of its program.
    """

    name: str
    composition: Composition | None = None
    program: CheckedProgram | None = None
    abstract: str = ""
    allocation: str = ""
    member: str = ""
    above: int = 0
    background: Composition | None = None

    @property
    def part(self) -> str:
        """Name of the member whose predicate its program gives."""
        return self.member or self.abstract or self.name

    @property
    def controllers(self) -> tuple[Controller, ...]:
        """Controllers of its composition, in written order; none where it is a program."""
        return () if self.composition is None else self.composition.controllers


class PriorLook(NamedTuple):
    """A program that defines a feature, run before anything is allocated where that is undefined.

    Attributes:
        program: what runs, such as SEARCHTRACK of the feature's channel.
        name: of that program.
        policy: name of the learned policy that it runs under, if it does.
        values: of its parameters.
    """

    program: CheckedProgram
    name: str
    policy: str | None
    values: Mapping[str, str]


class Guards(NamedTuple):
    """Bounds on what a motion presses with; ``None`` for no bound.

    Attributes:
        finger_force: of a fingertip, N.
        hand_force: net force of a hand, N.
        joint_torque: of all joints of an arm together, by contacts anywhere on it, N m.
    """

    finger_force: float | None = None
    hand_force: float | None = None
    joint_torque: float | None = None

    def within(self, other: Guards) -> Guards:
        """The narrower bounds of two."""
        pairs = zip(self, other, strict=True)
        return Guards(*(min((x for x in pair if x is not None), default=None) for pair in pairs))


NO_GUARDS = Guards()


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
        schema: what chooses the resources of its actions, where it is a schema.
        episode_time: longest time of an episode, s; ``None`` for no limit.
        reward_ends: whether the first reward ends an episode that is not learned from.
        success: patterns of states in which it has succeeded.
        failure: patterns of states in which it has failed.
        guards: bounds on what it may press with.
        is_learned: whether its policy was learned.
        lost_time: longest time for which an object that was seen may be remembered nowhere, s;
            ``None`` for no limit.
        looks: what defines features of its schema, by their names, in the order in which it is
            done.
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
    schema: Schema | None = None
    episode_time: float | None = None
    reward_ends: bool = True
    success: tuple[str, ...] = ()
    failure: tuple[str, ...] = ()
    guards: Guards = NO_GUARDS
    is_learned: bool = False
    looks: Mapping[str, PriorLook] = {}
    lost_time: float | None = None

    @property
    def all_guards(self) -> Guards:
        """Its bounds, and those of the programs that it uses where they are narrower."""
        guards = self.guards
        for action in self.actions:
            if action.program is not None:
                guards = guards.within(action.program.all_guards)
        return guards

    @property
    def sequential_actions(self) -> tuple[Action, ...]:
        """The actions of a single member, without co-articulation (Section 4.2.1)."""
        return tuple(action for action in self.actions if action.name in self.members)
