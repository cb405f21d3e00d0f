"""Correspondences between programs that are rewarded for the same (Section 5.3.2)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.program.controller import Composition, Primitive

_Kind = tuple[str, str, str]


def affordances(program: CheckedProgram) -> frozenset[str]:
    """Types of the signals whose quiescence a program is rewarded for (Eq 4.4)."""
    return frozenset(
        str(earner.feedback.type.name)
        for primitive in program.primitives.values()
        for earner in primitive.earners
    )


def correspondence(program: CheckedProgram, other: CheckedProgram) -> dict[str, str] | None:
    """Members of a program by the members of another that stand for the same abstract actions.

    Members correspond by potential, type of feedback and whether they are rewarded, or by the
    program that they are; names do not matter. Of the effectors only the types of what they
    move by are abstract here: two hands press with their arms, and one with its fingers.

    Returns:
        ``None`` where some member has no counterpart or several, or some action has none.
    """
    ours, theirs = _by_kind(program), _by_kind(other)
    if ours is None or theirs is None or ours.keys() != theirs.keys():
        return None
    names = {theirs[kind]: ours[kind] for kind in ours}
    wanted = {action.name for action in program.actions}
    return names if {_renamed(each, names).name for each in other.actions} == wanted else None


def in_place_of(
    program: CheckedProgram, other: CheckedProgram, names: Mapping[str, str]
) -> CheckedProgram:
    """Another program with the members and actions of the one that it stands in for, in its order.

    Which part of an action leads is for the one to say who does it: two hands that press with the
    arms by which they reach cannot press below the reach. So where its own policy chooses the same
    parts in another order only, they are in that order.

    Args:
        program: that keeps its name.
        other: what stands in for it.
        names: as ``correspondence`` has them.
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
    """Action of the same parts, as they are chosen, under the name of the one it stands in for."""
    exact = next(each for each in known if each.name == action.name)
    same = [each for each in chosen if _parts(each) == _parts(exact)]
    if not same or exact in same:
        return exact
    return same[0]._replace(name=action.name)


def _parts(action: Action) -> frozenset[str]:
    """Names of the primitives of an action, or of its program."""
    if action.composition is None:
        return frozenset({action.name})
    return frozenset(each.name for each in action.composition.primitives)


def _by_kind(program: CheckedProgram) -> dict[_Kind, str] | None:
    """Members by what they are in the abstract; ``None`` where two are the same."""
    used = {action.name: action.program for action in program.actions if action.program is not None}
    kinds: dict[_Kind, str] = {}
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
