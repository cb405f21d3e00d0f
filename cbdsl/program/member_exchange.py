"""Member exchange: another program in the place of one member of a program (Section 5.3.2)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.program.controller import Composition
from cbdsl.program.stand_in import RewardKind
from cbdsl.types.resource import StereoPosition
from cbdsl.types.state import Predicate


class EarnedSignal(NamedTuple):
    """A signal whose quiescence is rewarded.

    Attributes:
        kind: of quiescence, in the abstract.
        signal: name of the resource that is sensed.
    """

    kind: RewardKind
    signal: str


def exchange(program: CheckedProgram, member: str, other: CheckedProgram) -> CheckedProgram:
    """A program that runs another one wherever it ran a member.

    The state keeps one predicate for the member, which then is that of the other program. Where
    the member was composed with others, these act first, and the program as soon as they are at
    rest; meanwhile the member is undefined.

    Args:
        program: whose member is exchanged.
        member: name of one of its members.
        other: what runs instead.
    """
    actions = tuple(_exchanged(action, member, other) for action in program.actions)
    return program._replace(actions=actions)


def _exchanged(action: Action, member: str, other: CheckedProgram) -> Action:
    if action.name == member:
        return action._replace(composition=None, program=other)
    primitives = () if action.composition is None else action.composition.primitives
    if member not in [each.name for each in primitives]:
        return action
    place = [each.name for each in primitives].index(member)
    rest = Composition((*primitives[:place], *primitives[place + 1 :]))
    above = sum(len(each.controllers) for each in primitives[place + 1 :])
    return action._replace(composition=rest, program=other, member=member, above=above)


def member_signals(program: CheckedProgram, member: str) -> frozenset[EarnedSignal]:
    """Signals whose quiescence a member of a program is rewarded for, or the program that it is."""
    child = member_program(program, member)
    if child is not None:
        return earned_signals(child)
    return frozenset(_of_primitive(program, member))


def earned_signals(program: CheckedProgram) -> frozenset[EarnedSignal]:
    """Signals whose quiescence a program is rewarded for."""
    return frozenset(each for name in program.primitives for each in _of_primitive(program, name))


def signals_at_its_end(program: CheckedProgram) -> frozenset[EarnedSignal]:
    """Those of them that are at rest when it has succeeded.

    A program that states when it has succeeded ends with what that asks to be at rest; another one
    with whatever rewards it, if its reward ends it.
    """
    if not program.success:
        return earned_signals(program) if program.reward_ends else frozenset()
    asked = {
        name
        for pattern in program.success
        for name, letter in zip(program.members, pattern, strict=True)
        if letter == Predicate.QUIESCENT
    }
    return frozenset(
        each for name in asked & set(program.primitives) for each in _of_primitive(program, name)
    )


def places_seen(program: CheckedProgram) -> frozenset[str]:
    """Names of the seen positions that a program goes by, and the programs that it uses."""
    own = {
        resource.name
        for action in program.actions
        for controller in action.controllers
        for resource in controller.resources
        if isinstance(resource.source, StereoPosition)
    }
    used = (places_seen(action.program) for action in program.actions if action.program is not None)
    return frozenset(own).union(*used)


def member_places(program: CheckedProgram, member: str) -> frozenset[str]:
    """The same of a member that is a program; a controller is where its program has led it."""
    child = member_program(program, member)
    return frozenset() if child is None else places_seen(child)


def member_program(program: CheckedProgram, member: str) -> CheckedProgram | None:
    """The program that a member is, ``None`` for a controller."""
    return next((each.program for each in program.actions if each.name == member), None)


def _of_primitive(program: CheckedProgram, name: str) -> Iterator[EarnedSignal]:
    for earner in program.primitives[name].earners:
        yield EarnedSignal(RewardKind.of(earner), earner.feedback.name)
