"""Links of a proposed robot that touch each other in the start posture."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

from cbdsl.robot.semantic_groups import SemanticGroup
from cbdsl.robot.urdf import UrdfError, UrdfModel

if TYPE_CHECKING:
    from cbdsl.kinematics.self_contacts import LinkPair, SelfContacts

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


def _touching(
    contacts: SelfContacts,
    effectors: Mapping[str, SemanticGroup],
    postures: Mapping[str, Postures],
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
