"""Correspondences between programs with the same rewards (Section 5.3.2)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.program.controller import Composition, Primitive

_Kind = tuple[str, str, str]


def affordances(program: CheckedProgram) -> frozenset[str]:
    """Return the types of the signals whose quiescence a program is rewarded for (Eq 4.4)."""
    return frozenset(
        str(earner.feedback.type.name)
        for primitive in program.primitives.values()
        for earner in primitive.earners
    )


def correspondence(program: CheckedProgram, other: CheckedProgram) -> dict[str, str] | None:
    """Return members of a program by the members of another for the same abstract actions.

    Members correspond by potential, type of feedback and whether they are rewarded, or by their
    program if they are programs; names do not matter. Only the type of motion of an effector
    is abstract here: two hands press with their arms, and one with its fingers.

    Returns:
        Names in the first program by names in the other; ``None`` if a member has no counterpart or
        several, or an action has none.
    """
    # Names differ between programs, so that the kind alone identifies a member. Two members of the
    # same kind, for example two equal reaches, make the match ambiguous.
    ours, theirs = _by_kind(program), _by_kind(other)
    if ours is None or theirs is None or ours.keys() != theirs.keys():
        return None
    names = {theirs[kind]: ours[kind] for kind in ours}
    # Each action needs a counterpart, because the policy of the program is kept and refers to it.
    wanted = {action.name for action in program.actions}
    return names if {_renamed(each, names).name for each in other.actions} == wanted else None


def in_place_of(
    program: CheckedProgram, other: CheckedProgram, names: Mapping[str, str]
) -> CheckedProgram:
    """Return another program with the members and actions of the replaced one, in its order.

    The replacement decides which part of an action leads: two hands that press with the arms by
    which they reach cannot press below the reach. So if its own policy chooses the same parts
    only in another order, they keep that order.

    Args:
        program: Replaced program, whose name is kept.
        other: Program that stands in for it.
        names: Names of members, as returned by ``correspondence``.
    """
    own = {each.name: _renamed(each, names) for each in other.actions}
    chosen = [own[name] for name in dict.fromkeys(other.policy.values()) if name in own]
    primitives = {
        names[name]: primitive._replace(name=names[name])
        for name, primitive in other.primitives.items()
    }
    return other._replace(
        name=program.name,
        members=program.members,
        primitives={name: primitives[name] for name in program.primitives},
        actions=tuple(_as_chosen(each, list(own.values()), chosen) for each in program.actions),
        policy=program.policy,
    )


def _as_chosen(action: Action, known: Sequence[Action], chosen: Sequence[Action]) -> Action:
    """Return the action with the same parts, in their chosen order, under the given name."""
    exact = next(each for each in known if each.name == action.name)
    same = [each for each in chosen if _parts(each) == _parts(exact)]
    # Example: the program runs A ◁ B, and the policy of the other one only chooses B ◁ A.
    if not same or exact in same:
        return exact
    return same[0]._replace(name=action.name)


def _parts(action: Action) -> frozenset[str]:
    """Return the names of the primitives of an action, or of its program."""
    if action.composition is None:
        return frozenset({action.name})
    return frozenset(each.name for each in action.composition.primitives)


def _by_kind(program: CheckedProgram) -> dict[_Kind, str] | None:
    """Return members by their abstract kind, or ``None`` if two have the same kind."""
    used = {action.name: action.program for action in program.actions if action.program is not None}
    kinds: dict[_Kind, str] = {}
    if program.conditions:
        return None  # a condition has no kind that another program could share
    for name in program.members:
        child = used.get(name)
        kind = _abstract(program.primitives[name]) if child is None else ("program", child.name, "")
        if kind in kinds:
            return None
        kinds[kind] = name
    return kinds


def _abstract(primitive: Primitive) -> _Kind:
    lead = primitive.earners[-1] if primitive.earners else primitive.lead
    return lead.potential, str(lead.feedback.type.name), "rewarded" if primitive.earners else ""


def _renamed(action: Action, names: Mapping[str, str]) -> Action:
    if action.composition is None:
        return action._replace(name=names[action.name])
    composition = Composition(
        tuple(each._replace(name=names[each.name]) for each in action.composition.primitives)
    )
    return action._replace(name=str(composition), composition=composition)
