"""From levels to joint references: the control law applied to what acts in a tick."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.crew import Crew
from cbdsl.control.law import Law, LawSettings, Step
from cbdsl.control.stack import Stack
from cbdsl.documents.robot import RobotDocument
from cbdsl.runtime.controller_run import ControllerRun
from cbdsl.runtime.program_run import Active
from cbdsl.sensing.signals import Signals

Floats = NDArray[np.float64]
Columns = NDArray[np.intp]

# Controllers, and the names of those that each acts together with.
_Acting = tuple[tuple[ControllerRun, tuple[str, ...]], ...]


class _Shift(NamedTuple):
    """Controllers that act at once: none of them asks what those above it have come to.

    Attributes:
        sensing: those of them that have anything to read.
        first, last: places of the first of them, and after the last of them.
        acts: whether one acts in any case, since it has nothing to read.
    """

    sensing: tuple[Active, ...]
    first: int
    last: int
    acts: bool


class _Composition(NamedTuple):
    """What acts together.

    Attributes:
        active: its controllers, highest priority first, with those that they act together with.
        runs: its controllers alone.
        columns: indices of its joints among all actuated ones, shape (n,).
        moved: the same for each controller, -1 for joints that it does not move, shape (runs, n).
        law: of these joints.
        stack: the levels of its controllers.
        crew: its controllers, as they act in one compiled call.
        shifts: what is to be done one after another.
    """

    active: Sequence[Active]
    runs: tuple[ControllerRun, ...]
    columns: Columns
    moved: Columns
    law: Law
    stack: Stack
    crew: Crew
    shifts: tuple[_Shift, ...]

    def begin(self) -> None:
        """Act instead of something else."""
        self.stack.forget()
        for place, run in enumerate(self.runs):
            run.join(self.stack, place, self.moved[place])


class Actuation:
    """Integrates the law's displacements into joint references.

    Attributes:
        settings: the law's guards for ticks of this length.
        reference: position references of all actuated joints, rad, shape (n,).
        step: what the law made of the last tick's levels, or ``None`` where nothing acted.
    """

    def __init__(self, robot: RobotDocument, signals: Signals, period: float) -> None:
        self._control = robot.control
        self._signals = signals
        # The robot's are those for its own rate. In a tick that lasts longer the joints move
        # farther, and a small Jacobian is another one by then, unless it is larger by as much.
        longer = period * robot.control.rate
        self.settings = LawSettings(
            damping=robot.control.damping * longer**2,
            singular_value=robot.control.singular_value * longer,
            joint_step=robot.control.joint_speed * period,
            limit_margin=robot.control.limit_margin,
        )
        self._compositions: dict[_Acting, _Composition] = {}

    def reset(self, positions: Floats) -> None:
        """Start from measured positions, rad, shape (n,)."""
        self.reference = positions.copy()
        self.step: Step | None = None
        self._last: _Composition | None = None

    def move(self, active: Sequence[Active]) -> None:
        """Evaluate the active controllers and move the references by the law's step."""
        self.step = None
        # A program that has ended leaves nothing to act.
        if not active:
            self._last = None
            return
        found = self._last
        if found is None or active is not found.active:
            found = self._composition(active)
            if found is not self._last:
                self._last = found
                found.begin()
        found.stack.turn()
        if not self._act(found):
            return
        positions, columns = self._signals.positions, found.columns
        lead = self._control.lead
        self.step = found.law.advance(found.stack, self.reference, positions, columns, lead)

    def _act(self, composition: _Composition) -> bool:
        """Write the levels of this tick; returns whether there are any."""
        positions, posture = self._signals.positions, self._signals.tips.stamp
        acting = False
        for sensing, first, last, acts in composition.shifts:
            acting |= acts
            for run, peers in sensing:
                acting |= run.sense(peers)
            done = composition.crew.act(first, last, positions, posture)
            while done < last:
                composition.runs[done].evaluate()
                done = composition.crew.act(done + 1, last, positions, posture)
        return acting

    def at_limits(self) -> tuple[str, ...]:
        """The joints that their limits held back in the last tick."""
        if self._last is None or self.step is None:
            return ()
        return tuple(
            self._signals.joints.names[column]
            for column, locked in zip(self._last.columns, self.step.locked, strict=True)
            if locked
        )

    def _composition(self, active: Sequence[Active]) -> _Composition:
        """What acts, made when it acts for the first time."""
        key = tuple([(item.run, tuple(item.peers)) for item in active])
        found = self._compositions.get(key)
        if found is None:
            found = self._compositions[key] = self._composed(active)
        return found

    def _composed(self, active: Sequence[Active]) -> _Composition:
        """The active controllers' levels, and the union of their joints."""
        runs = tuple([item.run for item in active])
        joints = tuple(dict.fromkeys(joint for run in runs for joint in run.controller.joints))
        columns = self._signals.joints.pick(joints)
        limits = self._signals.kinematics
        law = Law(limits.lower[columns], limits.upper[columns], self.settings)
        stack = Stack([(run.controller.name, run.size) for run in runs], len(columns))
        moved = np.array([np.where(np.isin(columns, run.own), columns, -1) for run in runs])
        crew = Crew([run.member for run in runs], stack, moved)
        return _Composition(active, runs, columns, moved, law, stack, crew, _shifts(active))


def _shifts(active: Sequence[Active]) -> tuple[_Shift, ...]:
    """Begins anew with every controller that asks what those above it have come to."""
    starts = [place for place, item in enumerate(active) if item.run.asks and place > 0]
    return tuple(
        _Shift(
            tuple(item for item in active[first:last] if not item.run.needs_nothing),
            first,
            last,
            any(item.run.needs_nothing for item in active[first:last]),
        )
        for first, last in pairwise((0, *starts, len(active)))
    )
