"""Links of a proposed robot that touch each other in the start posture."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

from cbdsl.robot.link_place import PLACING
from cbdsl.robot.semantic_groups import SemanticGroup
from cbdsl.robot.urdf import UrdfError, UrdfJoint, UrdfModel
from cbdsl.robot.weight import overloads

if TYPE_CHECKING:
    from cbdsl.kinematics.self_contacts import LinkPair, SelfContacts

# Turns of an arm at its first joint, rad, and the begin of the names of such postures: no name of
# a posture has a space.
_TURNS = tuple(math.radians(side * turn) for turn in (15, 30, 45, 60, 90) for side in (1, -1))
_APART = "apart "
#: Postures of an effector by name; the first is its start posture.
Postures = dict[str, tuple[float, ...]]


class StartContacts(NamedTuple):
    """Start postures, and the links that touch each other there.

    Attributes:
        postures: Postures by effector, start posture first.
        always: Pairs of links that touch in every tested posture.
        there: Pairs of other links that touch in the start posture.
        unknown: Reason why the contacts were not computed; else empty.
    """

    postures: dict[str, Postures]
    always: tuple[LinkPair, ...] = ()
    there: tuple[LinkPair, ...] = ()
    unknown: str = ""


def start_contacts(
    model: UrdfModel, effectors: Mapping[str, SemanticGroup], postures: Mapping[str, Postures]
) -> StartContacts:
    """Return the postures ordered so that few links touch, and the links that still touch.

    Args:
        model: Model of the robot.
        effectors: Proposed effectors by name.
        postures: Postures by effector, preferred one first; the order of an SRDF is kept.
    """
    try:
        from cbdsl.kinematics.self_contacts import SelfContacts

        contacts = SelfContacts(model)
    except ImportError:
        return StartContacts(dict(postures), unknown="pip install 'cbdsl[sim]' looks for them")
    except UrdfError:
        return StartContacts(dict(postures))  # the document gets a diagnostic for it
    always = contacts.always()
    chosen, there = _cleared(contacts, effectors, dict(postures))
    if there - always:
        chosen, there = _cleared(contacts, effectors, _with_turns(model, effectors, chosen))
        chosen = {name: _without_idle_turns(own) for name, own in chosen.items()}
    # Pairs that the start posture separates are not permanent contacts.
    always &= there
    return StartContacts(chosen, tuple(sorted(always)), tuple(sorted(there - always)))


def _cleared(
    contacts: SelfContacts, effectors: Mapping[str, SemanticGroup], chosen: dict[str, Postures]
) -> tuple[dict[str, Postures], frozenset[LinkPair]]:
    """Return the postures, reordered so that fewer links touch, and the pairs that still touch."""
    there = _touching(contacts, effectors, chosen)
    for name, own in chosen.items():
        if effectors[name].postures:
            continue
        # Greedy: one effector at a time, with the others where they are. All combinations would be
        # too many for robots with several limbs.
        for start in own:
            # The first posture of an effector is its start; the merged dictionary keeps the others
            # behind it.
            tried = {**chosen, name: {start: own[start], **own}}
            touching = _touching(contacts, effectors, tried)
            if len(touching) < len(there):
                chosen, there = tried, touching
    return chosen, there


def _with_turns(
    model: UrdfModel, effectors: Mapping[str, SemanticGroup], chosen: Mapping[str, Postures]
) -> dict[str, Postures]:
    """Return the postures with turns of whole arms, at their first joint, behind them."""
    return {
        name: {**own, **_turns(model, effectors[name].joints, next(iter(own.values())))}
        if effectors[name].tip is not None and len(effectors[name].joints) >= PLACING
        else own
        for name, own in chosen.items()
    }


def _turns(
    model: UrdfModel, joints: tuple[UrdfJoint, ...], start: tuple[float, ...]
) -> dict[str, tuple[float, ...]]:
    """Return a start posture with its first joint turned, the smallest turns first."""
    first, efforts = joints[0], {joint.name: joint.effort for joint in joints}
    turns: dict[str, tuple[float, ...]] = {}
    for turn in () if first.slides else _TURNS:
        angles = (start[0] + turn, *start[1:])
        given = {joint.name: angle for joint, angle in zip(joints, angles, strict=True)}
        if first.lower < angles[0] < first.upper and not overloads(model, given, efforts):
            turns[f"{_APART}{len(turns)}"] = angles
    return turns


def _without_idle_turns(own: Postures) -> Postures:
    """Return the postures with the turn that comes first, if one does, and no other."""
    first, *others = own
    kept = {name: own[name] for name in others if not name.startswith(_APART)}
    return {"apart" if first.startswith(_APART) else first: own[first], **kept}


def _touching(
    contacts: SelfContacts, effectors: Mapping[str, SemanticGroup], postures: Mapping[str, Postures]
) -> frozenset[LinkPair]:
    """Return the pairs of links that touch in the start postures of all effectors."""
    return contacts.touching(
        {
            joint.name: position
            for name, own in postures.items()
            for joint, position in zip(
                effectors[name].joints, next(iter(own.values())), strict=True
            )
        }
    )
