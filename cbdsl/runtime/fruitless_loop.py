"""Loop of actions that changes no signal of a program."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import inf
from typing import NamedTuple

import numpy as np

from cbdsl.numeric.arrays import Floats
from cbdsl.program.checked import CheckedProgram, resources_of
from cbdsl.sensing.signals import Signals
from cbdsl.types.resource import Origin

# A loop has at most this many transitions. An action that takes longer than this, s, and moves no
# joint waits, by its quiescence or its limit of time, for an event that may come.
_LONGEST, _ACTION = 8, 1.0
# Time for which nothing has to change, s, and at least a round: images may lack an object for a
# moment. A loop that moves to places and back may wait for an event, too, for a longer time.
_PATIENCE, _PATIENCE_IN_MOTION = 3.0, 30.0
# Changes that count, by the unit of a signal; they exceed the noise of joints and load cells.
_CHANGES = {"m": 2e-3, "rad": 1e-2, "N": 0.5, "Nm": 0.05}
_OTHER = 1e-2

_MEASURED = {Origin.ENVIRONMENT, Origin.PROPRIOCEPTION, Origin.KINEMATICS, Origin.TRIANGULATION}


class _Change(NamedTuple):
    """Transition: its time, s, action and state, and joint positions and signals at its end."""

    time: float
    action: str
    state: str
    values: Sequence[Floats | None]


def last_rounds(course: Sequence[object], longest: int, least: int) -> tuple[int, int]:
    """Return the length of the shortest round that a course ends with, and how often it recurs.

    Args:
        course: Course, such as of actions with their states.
        longest: Maximum length of a round.
        least: Minimum number of equal rounds.

    Returns:
        Length and number of rounds; 0 and 0 without a round.
    """
    for size in range(1, min(longest, len(course) // least) + 1):
        last, rounds, end = course[-size:], 1, len(course) - size
        while course[max(0, end - size) : end] == last:
            rounds, end = rounds + 1, end - size
        if rounds >= least:
            return size, rounds
    return 0, 0


class FruitlessLoop:
    """Finder of a loop of actions that recurs while no measured signal changes.

    Predicates alone do not show a change: they stay while an object moves or a finger closes. So
    the signals that the program and its subprograms read are compared with those a round before. A
    loop whose joints move may be meant, such as a wave: it ends only if one of its states is
    undefined.

    Args:
        program: Program whose transitions are noted.
        signals: Signals of its robot.
    """

    def __init__(self, program: CheckedProgram, signals: Signals) -> None:
        self._program, self._signals = program, signals
        self._resources = [r for r in resources_of(program) if r.origin in _MEASURED]
        self.forget()

    def forget(self) -> None:
        """Begin an episode."""
        self._passed: list[_Change] = []
        self._before: list[Sequence[Floats | None]] = []
        self._since = 0.0

    def note(self, action: str, state: str) -> str:
        """Note a transition.

        Args:
            action: Name of the action that ended.
            state: Predicates at its end.

        Returns:
            Clause on a loop that has changed nothing for too long; empty without one.
        """
        now = _Change(self._signals.time, action, state, self._values())
        self._passed = [*self._passed[-2 * _LONGEST :], now]
        size, _ = last_rounds([each[1:3] for each in self._passed], _LONGEST, 2)
        around = self._passed[-1 - size :]
        if not size or len(self._passed) <= 2 * size:
            self._before = []
        elif len(self._before) != size or not self._is_same(now.values, self._before[0]):
            # Values are compared with those at the last change, so that a slow drift counts.
            self._before, self._since = [each.values for each in around[1:]], now.time
        else:
            self._before = [*self._before[1:], self._before[0]]
            passed = now.time - self._since
            if passed >= max(self._patience(around), now.time - around[0].time):
                return self._clause(around[1:], passed)
        return ""

    def _patience(self, around: Sequence[_Change]) -> float:
        """Return the time, s, for which a round, after the transition before it, may recur."""
        kept = [self._is_same(now.values, old.values) for old, now in pairwise(around)]
        lasts = [now.time - old.time for old, now in pairwise(around)]
        if any(same and time > _ACTION for same, time in zip(kept, lasts, strict=True)):
            return inf
        moving = _PATIENCE_IN_MOTION if any("-" in each.state for each in around) else inf
        return _PATIENCE if all(kept) else moving

    def _values(self) -> list[Floats | None]:
        """Return the joint positions, rad and m, and the value of each signal in SI units."""
        readings = [self._signals.read(resource) for resource in self._resources]
        return [self._signals.positions.copy(), *(r and r.value for r in readings)]

    def _is_same(self, now: Sequence[Floats | None], before: Sequence[Floats | None]) -> bool:
        """Return whether no value differs from the one before by more than noise."""
        # Slides of fingers count in the unit of turning joints, whose step is the larger one.
        bounds = [_CHANGES["m"], *(_CHANGES.get(r.type.units[0], _OTHER) for r in self._resources)]
        return all(
            value is old if value is None or old is None else np.abs(value - old).max() <= bound
            for value, old, bound in zip(now, before, bounds, strict=True)
            if value is None or value.size
        )

    def _clause(self, loop: Sequence[_Change], passed: float) -> str:
        """Return the loop and the signals that stayed undefined as a clause."""
        actions = dict.fromkeys(each.action for each in loop)
        names = [self._program.steps.get(action, action) for action in actions]
        around = " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
        pairs = zip(self._resources, self._passed[-1].values[1:], strict=True)
        lacking = [resource.name for resource, value in pairs if value is None][:3]
        stayed = f": {' and '.join(lacking)} stayed undefined" if lacking else ""
        return f"went round {around} for {passed:.1f} s, and no round changed a signal{stayed}"
