"""Member exchange: another program in the place of one member of a program (Section 5.3.2)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.program.controller import Composition
from cbdsl.program.stand_in import RewardKind
from cbdsl.types.source_record import is_located
from cbdsl.types.state import ARRIVED, Predicate


class EarnedSignal(NamedTuple):
    """Signal whose quiescence is rewarded.

    Attributes:
        kind: Kind of quiescence, in the abstract.
        signal: Name of the sensed resource.
    """

    kind: RewardKind
    signal: str


def exchange(program: CheckedProgram, member: str, other: CheckedProgram) -> CheckedProgram:
    """Return a program that runs another one in place of a member.

    The state keeps one predicate for the member, which then is the predicate of the other program.
    If the member was composed with others, these act first, and the program as soon as they are
    at rest; meanwhile the member is undefined.

    Args:
        program: Program whose member is exchanged.
        member: Name of one of its members.
        other: Program that runs instead.
    """
    actions = tuple(_exchanged(action, member, other) for action in program.actions)
    return program._replace(actions=actions)


def _exchanged(action: Action, member: str, other: CheckedProgram) -> Action:
    if action.name == member:
        return action._replace(composition=None, program=other)
    primitives = () if action.composition is None else action.composition.primitives
    if member not in [each.name for each in primitives]:
        return action
    # Primitives are in written order, so that those after the member have priority over it.
    place = [each.name for each in primitives].index(member)
    rest = Composition((*primitives[:place], *primitives[place + 1 :]))
    above = sum(len(each.controllers) for each in primitives[place + 1 :])
    return action._replace(composition=rest, program=other, member=member, above=above)


def member_signals(program: CheckedProgram, member: str) -> frozenset[EarnedSignal]:
    """Return the signals whose quiescence a member, or its program, is rewarded for."""
    child = member_program(program, member)
    if child is not None:
        return earned_signals(child)
    return frozenset(_of_primitive(program, member))


def earned_signals(program: CheckedProgram) -> frozenset[EarnedSignal]:
    """Return the signals whose quiescence a program is rewarded for."""
    return frozenset(each for name in program.primitives for each in _of_primitive(program, name))


def signals_at_its_end(program: CheckedProgram) -> frozenset[EarnedSignal]:
    """Return the rewarded signals that are at rest when a program has succeeded.

    A program with patterns of success ends with the signals at rest that they require. For any
    other program these are all its rewarded signals if its reward ends it, and none otherwise.
    """
    if not program.success:
        return earned_signals(program) if program.reward_ends else frozenset()
    asked = {
        name
        for pattern in program.success
        for name, letter in zip(program.members, pattern, strict=True)
        if letter in (Predicate.QUIESCENT, ARRIVED)
    }
    return frozenset(
        each for name in asked & set(program.primitives) for each in _of_primitive(program, name)
    )


def places_seen(program: CheckedProgram) -> frozenset[str]:
    """Return names of the seen positions that a program and the programs within it depend on."""
    own = {
        resource.name
        for action in program.actions
        for controller in action.controllers
        for resource in controller.resources
        if is_located(resource.source)
    }
    used = (places_seen(action.program) for action in program.actions if action.program is not None)
    return frozenset(own).union(*used)


def member_places(program: CheckedProgram, member: str) -> frozenset[str]:
    """Return the seen positions of a member that is a program; empty for a controller."""
    child = member_program(program, member)
    return frozenset() if child is None else places_seen(child)


def member_program(program: CheckedProgram, member: str) -> CheckedProgram | None:
    """Return the program of a member, or ``None`` for a controller."""
    return next((each.program for each in program.actions if each.name == member), None)


def _of_primitive(program: CheckedProgram, name: str) -> Iterator[EarnedSignal]:
    for earner in program.primitives[name].earners:
        yield EarnedSignal(RewardKind.of(earner), earner.feedback.name)
