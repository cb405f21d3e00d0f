"""Loop of quick actions that changes no signal of a program."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cbdsl.numeric.arrays import Floats
from cbdsl.program.checked import CheckedProgram, resources_of
from cbdsl.sensing.signals import Signals
from cbdsl.types.resource import Origin

# A loop has at most this many transitions, and this time, s, for each. A slower action waits, by
# its quiescence or its limit of time, for an event that may come.
_LONGEST, _ACTION = 8, 1.0
# Time for which nothing has to change, s, and at least a round: images may lack an object for a
# moment.
_PATIENCE = 3.0
# Changes that count, by the unit of a signal; they exceed the noise of joints and load cells.
_CHANGES = {"m": 2e-3, "rad": 1e-2, "N": 0.5, "Nm": 0.05}
_OTHER = 1e-2

_MEASURED = {Origin.ENVIRONMENT, Origin.PROPRIOCEPTION, Origin.KINEMATICS, Origin.TRIANGULATION}


class _Still(NamedTuple):
    """Values of all signals when they last changed, and the time, s."""

    time: float
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
    the signals that the program and its subprograms read are compared as well.

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
        self._passed: list[tuple[float, str, str]] = []
        self._still: _Still | None = None

    def note(self, action: str, state: str) -> str:
        """Note a transition.

        Args:
            action: Name of the action that ended.
            state: Predicates at its end.

        Returns:
            Clause on a loop that has changed nothing for too long; empty without one.
        """
        time = self._signals.time
        self._passed = [*self._passed[-2 * _LONGEST :], (time, action, state)]
        size = self._loop()
        if not size:
            self._still = None
            return ""
        values = self._values()
        if self._still is None or not self._is_same(values, self._still.values):
            self._still = _Still(time, values)
        passed = time - self._still.time
        if passed < max(_PATIENCE, time - self._passed[-1 - size][0]):
            return ""
        loop = dict.fromkeys(action for _, action, _ in self._passed[-size:])
        return self._clause(tuple(loop), passed, values)

    def _loop(self) -> int:
        """Return the length of a loop of quick actions whose last two rounds are the same, or 0."""
        times, done = [each[0] for each in self._passed], [each[1:] for each in self._passed]
        size, _ = last_rounds(done, _LONGEST, 2)
        if not size or len(done) <= 2 * size:
            return 0
        return size if max(np.diff(times[-1 - size :])) <= _ACTION else 0

    def _values(self) -> list[Floats | None]:
        """Return the joint positions, rad and m, and the value of each signal in SI units."""
        readings = [self._signals.read(resource) for resource in self._resources]
        return [self._signals.positions.copy(), *(r and r.value for r in readings)]

    def _is_same(self, now: Sequence[Floats | None], before: Sequence[Floats | None]) -> bool:
        """Return whether no value differs from the one before by more than noise."""
        # Slides of fingers count in the unit of turning joints, whose step is the larger one.
        bounds = [_CHANGES["m"], *(_CHANGES.get(r.type.units[0], _OTHER) for r in self._resources)]
        for value, old, bound in zip(now, before, bounds, strict=True):
            if value is None or old is None:
                if value is not old:
                    return False
            elif float(np.abs(value - old).max(initial=0.0)) > bound:
                return False
        return True

    def _clause(self, loop: Sequence[str], passed: float, values: Sequence[Floats | None]) -> str:
        """Return the loop and the signals that stayed undefined as a clause."""
        names = [self._program.steps.get(action, action) for action in loop]
        around = " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
        pairs = zip(self._resources, values[1:], strict=True)
        lacking = [resource.name for resource, value in pairs if value is None][:3]
        stayed = f": {' and '.join(lacking)} stayed undefined" if lacking else ""
        return f"went round {around} for {passed:.1f} s, and no signal changed{stayed}"
