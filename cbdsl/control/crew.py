"""The controllers that act together: what they do in a tick is one compiled call."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.composition import Integers
from cbdsl.control.kernel import act_all
from cbdsl.control.member import Member
from cbdsl.control.predicate import PREDICATE
from cbdsl.control.signal import Floats
from cbdsl.control.stack import Stack

Array = NDArray[Any]

_OF_MEMBER = "plan", "constants", "sources", "value", "reference", "jacobian", "outcome"
_OF_TASK = "bounds", "before"
_OF_MONITOR = "settings", "values", "notes"


class Crew:
    """Members that act in one composition; each may act in others, too.

    Args:
        members: highest priority first, all gathered together.
        stack: of their levels.
        columns: which joint each of the stack's n is for a member, -1 for those that count as
            still, shape (members, n).
    """

    def __init__(self, members: Sequence[Member], stack: Stack, columns: Integers) -> None:
        rows = np.array([member.row for member in members])
        levels = stack.rows, stack.wanted, stack.ages, stack.starts
        self._stack = stack
        self._arrays = *levels, *members[0].arrays, rows, columns

    def act(self, first: int, last: int, positions: Floats, posture: int) -> int:
        """Let members act, from the first up to the last.

        Args:
            first: place of the first of them.
            last: place after the last of them.
            positions: of all actuated joints, rad, shape (joints,).
            posture: stamp of the positions.

        Returns:
            ``last``, or the place of a member that has to be evaluated by itself: something is not
            finite. Those after it have not acted yet.
        """
        newest = self._stack.newest
        found: int = act_all(first, last, positions, posture, newest, *self._arrays)
        return found


def gather(members: Sequence[Member]) -> None:
    """Keep the arrays of members together, each of which goes on with its part of them."""
    kept = zip(*(_kept(member) for member in members), strict=True)
    arrays = tuple(_together(list(each)) for each in kept)
    for row, member in enumerate(members):
        member.arrays, member.row = arrays, row


def predicates_of(members: Sequence[Member]) -> Array:
    """Predicates of members that were gathered one after another, as numbers, shape (members,).

    They change with the predicates.
    """
    if not members:
        return np.zeros(0, dtype=np.int64)
    first, notes = members[0].row, members[0].arrays[-1]
    return notes[first : first + len(members), PREDICATE]


def _kept(member: Member) -> Iterator[tuple[object, str]]:
    """What a member keeps in arrays: whose attributes they are, and their names."""
    for owner, names in (
        (member, _OF_MEMBER),
        (member.task, _OF_TASK),
        (member.monitor, _OF_MONITOR),
    ):
        yield from ((owner, name) for name in names)


def _together(kept: Sequence[tuple[object, str]]) -> Array:
    """The arrays of all, one after another; attributes become parts of it."""
    parts: list[Array] = [getattr(owner, name) for owner, name in kept]
    shape = np.max([part.shape for part in parts], axis=0)
    rows = np.zeros((len(parts), *shape), dtype=parts[0].dtype)
    for row, part, (owner, name) in zip(rows, parts, kept, strict=True):
        own = row[tuple(slice(size) for size in part.shape)]
        own[...] = part
        setattr(owner, name, own)
    return rows
