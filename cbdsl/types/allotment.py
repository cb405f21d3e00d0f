"""Allotments: kinds of resources to which a program parameter may be bound (Section 5.2)."""

from __future__ import annotations

from typing import NamedTuple

EFFECTOR, CHANNEL, PROGRAM = "effector", "channel", "program"

#: Name of the program itself, in sections ``resources`` and in allocations.
WHOLE = "program"

#: Types of signals for which programs are rewarded.
REWARDED = ("force", "heading")

#: Types of signals that distinguish effectors: signals of joints, tips and load cells.
SENSED = ("configuration", "position", "orientation", "pose", "force")


class Allotment(NamedTuple):
    """Kind of resource.

    Attributes:
        kind: ``effector``, ``channel`` or ``program``.
        type: Signal type: one of ``SENSED`` for an effector, ``heading`` for a channel, one of
            ``REWARDED`` for a program.
    """

    kind: str
    type: str


ALLOTMENTS = {
    **{f"effector of {type_}": Allotment(EFFECTOR, type_) for type_ in SENSED},
    "heading channel": Allotment(CHANNEL, "heading"),
    **{f"program of {type_}": Allotment(PROGRAM, type_) for type_ in REWARDED},
}
"""All kinds by their spelling in documents."""


def allotment(text: str) -> Allotment | None:
    """Return the kind that a text names, or ``None``."""
    # YAML allows several spaces and line breaks between the words.
    return ALLOTMENTS.get(" ".join(text.split()))
