"""Checked program: immutable, fully resolved, ready to run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from cbdsl.program.automaton import Automaton
from cbdsl.program.condition import ProgramCondition
from cbdsl.program.controller import Composition, Controller, Primitive
from cbdsl.program.schema import Schema
from cbdsl.types.resource import LinkDistance, Resource
from cbdsl.types.source_record import sources_of

if TYPE_CHECKING:
    from cbdsl.documents.robot import HullSection


class Action(NamedTuple):
    """Action that a policy can select.

    Attributes:
        name: Action as written in its program, in canonical spelling.
        composition: Controllers to run, or ``None`` for a program.
        program: Program to run, or ``None`` for a composition. If both are set, the program
            replaces a member of that composition.
        abstract: Abstract action that this action allocates, as its program writes it; only in
            a schema.
        allocation: Name of that allocation; empty if no allocation changes the action.
        member: Member of a composition that the program replaces; empty in all other cases.
        above: Number of controllers of the composition with priority over that program.
        background: Composition that runs below the action under its allocation; ``None`` for the
            background of its program.
        conditions: Names of the conditions that are evaluated while it runs.
    """

    name: str
    composition: Composition | None = None
    program: CheckedProgram | None = None
    abstract: str = ""
    allocation: str = ""
    member: str = ""
    above: int = 0
    background: Composition | None = None
    conditions: tuple[str, ...] = ()

    @property
    def part(self) -> str:
        """Name of the member whose predicate the program provides."""
        return self.member or self.abstract or self.name

    @property
    def controllers(self) -> tuple[Controller, ...]:
        """Controllers of its composition, in written order; empty for a program."""
        return () if self.composition is None else self.composition.controllers


class PriorLook(NamedTuple):
    """Program that defines a feature; it runs before the allocation if the feature is undefined.

    Attributes:
        program: Program to run, such as SEARCHTRACK of the feature's channel.
        name: Name of that program.
        policy: Name of the learned policy that it runs under, or ``None``.
        values: Values of its parameters.
    """

    program: CheckedProgram
    name: str
    policy: str | None
    values: Mapping[str, str]


class Guards(NamedTuple):
    """Bounds on the contact loads and the links of a motion; ``None`` for no bound.

    Attributes:
        finger_force: Force of a fingertip, N.
        hand_force: Net force of a hand, N.
        joint_torque: Torque of all joints of an arm together, by contacts anywhere on it, N m.
        clearance: Least distance between links, m.
        seen: Positions of seen objects from which links keep it, too.
        fixtures: Names of fixtures of the stage from which links keep it, too.
        hulls: Hulls around them on the stage of a run, by name.
    """

    finger_force: float | None = None
    hand_force: float | None = None
    joint_torque: float | None = None
    clearance: float | None = None
    seen: tuple[Resource, ...] = ()
    fixtures: tuple[str, ...] = ()
    hulls: Mapping[str, HullSection] = {}

    def within(self, other: Guards) -> Guards:
        """Return the narrower bounds of two."""
        bounds = {
            name: narrower(given)
            for name, narrower in zip(self._fields, (min, min, min, max), strict=False)
            if (given := [x for x in (getattr(self, name), getattr(other, name)) if x is not None])
        }
        return Guards(
            **bounds,
            seen=tuple(dict.fromkeys(self.seen + other.seen)),
            fixtures=tuple(dict.fromkeys(self.fixtures + other.fixtures)),
            hulls={**self.hulls, **other.hulls},
        )


NO_GUARDS = Guards()


class CheckedProgram(NamedTuple):
    """Fully resolved program without errors.

    Attributes:
        name: Name of the program.
        robot: Robot that the program was checked for.
        stage: Default training context.
        parameters: Values of its parameters.
        members: Names of the controllers and programs behind a state's predicates, in order.
        primitives: Members that are primitives, by name.
        actions: Actions that a policy can select.
        policy: Action name by state pattern (one of ``X - 0 1 *`` per member).
        background: Composition that runs below every action.
        transitions: Maximum number of state transitions in an episode.
        transition_time: Maximum time of one action without a change of state, s.
        idle_time: Maximum time of one action while no predicate is 0 and no controller seeks a
            missing signal, s; ``None`` for no further limit.
        schema: Schema that chooses the resources of its actions, if it is a schema.
        episode_time: Maximum time of an episode, s; ``None`` for no limit.
        reward_ends: True if the first reward ends an episode outside of learning.
        success: Patterns of states in which it has succeeded.
        failure: Patterns of states in which it has failed.
        reasons: Reasons of failure, as clauses, by pattern; empty without one.
        guards: Bounds on its contact loads.
        is_learned: True if its policy was learned.
        lost_time: Maximum time for which a lost object may have no remembered position, s;
            ``None`` for no limit.
        looks: Programs that define features of its schema, by name of the feature, in order of
            execution.
        automaton: Automaton of its written steps; ``None`` for a policy over patterns of states.
        conditions: Conditions by name, which are members, too, behind all others.
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
    reasons: Mapping[str, str] = {}
    guards: Guards = NO_GUARDS
    is_learned: bool = False
    looks: Mapping[str, PriorLook] = {}
    lost_time: float | None = None
    automaton: Automaton | None = None
    conditions: Mapping[str, ProgramCondition] = {}

    @property
    def steps(self) -> dict[str, str]:
        """Names of its steps by action; empty for a policy over patterns of states."""
        steps = self.automaton.steps.values() if self.automaton else ()
        return {step.action: step.name for step in steps}

    @property
    def all_guards(self) -> Guards:
        """Narrowest bounds of the program and of the programs that it uses."""
        guards = self.guards
        for action in self.actions:
            if action.program is not None:
                guards = guards.within(action.program.all_guards)
        return guards

    @property
    def sequential_actions(self) -> tuple[Action, ...]:
        """Actions of a single member, without co-articulation (Section 4.2.1)."""
        return tuple(action for action in self.actions if action.name in self.members)


def fixtures_of(program: CheckedProgram) -> tuple[str, ...]:
    """Return the fixtures that links keep away from, or to which distances are signals."""
    distances = sources_of(resources_of(program), LinkDistance)
    measured = (each.other for each in distances if each.is_fixture)
    return tuple(dict.fromkeys((*program.all_guards.fixtures, *measured)))


def resources_of(program: CheckedProgram) -> Sequence[Resource]:
    """Return every resource that a program and the programs it uses can read."""
    resources: dict[Resource, None] = {}
    compositions = [program.background, *(action.composition for action in program.actions)]
    for composition in compositions:
        for controller in composition.controllers if composition else ():
            resources.update(dict.fromkeys(controller.resources))
    resources.update(dict.fromkeys(program.guards.seen))
    for condition in program.conditions.values():
        resources.update(dict.fromkeys(condition.resources))
    for action in program.actions:
        if action.program is not None:
            resources.update(dict.fromkeys(resources_of(action.program)))
    if program.schema is not None:
        resources.update(dict.fromkeys(program.schema.features.values()))
    for look in program.looks.values():
        resources.update(dict.fromkeys(resources_of(look.program)))
    return list(resources)
