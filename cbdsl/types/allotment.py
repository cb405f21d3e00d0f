"""Allotments: kinds of resources that a parameter of a program may stand for (Section 5.2)."""

from __future__ import annotations

from typing import NamedTuple

EFFECTOR, CHANNEL, PROGRAM = "effector", "channel", "program"

#: What stands for the program itself, in sections ``resources`` and in allocations.
WHOLE = "program"

#: Types of signals that programs are rewarded for.
REWARDED = ("force", "heading")

#: Types of signals by which effectors are told apart: of their joints, tips and load cells.
SENSED = ("configuration", "position", "orientation", "pose", "force")


class Allotment(NamedTuple):
    """A kind of resource.

    Attributes:
        kind: ``effector``, ``channel`` or ``program``.
        type: of a signal that the effector has, of ``SENSED``; ``heading`` for a channel; of what
            the program is rewarded for, of ``REWARDED``.
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
    """The kind that a text names, if it names one."""
    return ALLOTMENTS.get(" ".join(text.split()))
