"""Stand-ins: programs that earn the same rewards as a member of another (Section 5.3.2)."""

from __future__ import annotations

from typing import NamedTuple

from cbdsl.program.checked import CheckedProgram
from cbdsl.program.controller import Controller, Primitive


class RewardKind(NamedTuple):
    """Kind of a rewarded quiescence, in the abstract: a(phi, t_in, t_out) of Eq 5.1.

    Attributes:
        potential: Name of the potential.
        feedback, effector: Names of the types of the sensed and of the moved resource.
    """

    potential: str
    feedback: str
    effector: str

    @classmethod
    def of(cls, controller: Controller) -> RewardKind:
        """Return the kind of a rewarded controller's quiescence."""
        types = (str(each.type.name) for each in (controller.feedback, controller.effector))
        return cls(controller.potential, *types)

    def __str__(self) -> str:
        return f"{self.potential} of {self.feedback}, by {self.effector}"


class StandIn(NamedTuple):
    """Program in the place of a member of another.

    Attributes:
        member: Name of the replaced member.
        program: Name of the program.
        kind: Kind of quiescence that both are rewarded for.
    """

    member: str
    program: str
    kind: RewardKind


def stand_ins(program: CheckedProgram, other: CheckedProgram) -> list[StandIn]:
    """Return the members of a program that another one can stand in for, regardless of names.

    Both are rewarded for the same kind of quiescence. A program that uses the first one can be no
    part of it.
    """
    if program.name in used_names(other) | {other.name}:
        return []
    children = {each.name: each.program for each in program.actions if each.program is not None}
    theirs = _all_rewards(other)
    # A member that already is the other program needs no stand-in.
    return [
        StandIn(name, other.name, kind)
        for name in program.members
        if name not in program.conditions
        and (name not in children or children[name].name != other.name)
        for kind in sorted(
            theirs
            & (
                _all_rewards(children[name])
                if name in children
                else rewards_of(program.primitives[name])
            )
        )
    ]


def _all_rewards(program: CheckedProgram) -> set[RewardKind]:
    """Return the kinds of quiescence that any member of a program is rewarded for."""
    return {each for part in program.primitives.values() for each in rewards_of(part)}


def rewards_of(primitive: Primitive) -> set[RewardKind]:
    """Return the kinds of quiescence that a member is rewarded for."""
    return {RewardKind.of(each) for each in primitive.earners}


def used_names(program: CheckedProgram) -> set[str]:
    """Return the names of the programs that a program uses, at any depth."""
    children = [action.program for action in program.actions if action.program is not None]
    return {child.name for child in children}.union(*(used_names(child) for child in children))
