"""From levels to joint references: the control law applied to what acts in a tick."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.law import Law, LawSettings, Step
from cbdsl.control.stack import Stack
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.compiled import compiled_once
from cbdsl.robot.signals import Signals
from cbdsl.runtime.controller_run import ControllerRun
from cbdsl.runtime.program_run import Active

Floats = NDArray[np.float64]
Columns = NDArray[np.intp]


class _Composition(NamedTuple):
    """What acts together.

    Attributes:
        columns: indices of its joints among all actuated ones, shape (n,).
        lower: their lower limits with the margin, rad, shape (n,).
        upper: their upper limits with the margin, rad, shape (n,).
        law: of these joints.
        stack: the levels of its controllers.
    """

    columns: Columns
    lower: Floats
    upper: Floats
    law: Law
    stack: Stack


@compiled_once
def advance(
    reference: Floats,
    columns: Columns,
    displacement: Floats,
    here: Floats,
    lead: float,
    lower: Floats,
    upper: Floats,
) -> None:
    """Move references (all,) of the joints ``columns`` (n,) by a displacement (n,), rad.

    Args:
        here: measured positions, shape (n,).
        lead: how far a reference may be from them; else a blocked joint's would run away.
        lower: lower limits with their margin, shape (n,). A joint that is past one comes back at
            the law's pace, not at once.
        upper: upper limits with their margin, shape (n,).
    """
    for place in range(len(columns)):
        before = reference[columns[place]]
        wanted = before + displacement[place]
        wanted = min(max(wanted, here[place] - lead), here[place] + lead)
        lowest, highest = min(lower[place], before), max(upper[place], before)
        reference[columns[place]] = min(max(wanted, lowest), highest)


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
        self._compositions: dict[tuple[ControllerRun, ...], _Composition] = {}

    def reset(self, positions: Floats) -> None:
        """Start from measured positions, rad, shape (n,)."""
        self.reference = positions.copy()
        self.step: Step | None = None
        self._last: _Composition | None = None

    def move(self, active: Sequence[Active]) -> None:
        """Evaluate the active controllers and move the references by the law's step."""
        last, self._last, self.step = self._last, None, None
        # A program that has ended leaves nothing to act.
        if not active:
            return
        found = self._last = self._composition(active)
        columns, lower, upper, law, stack = found
        if found is not last:
            stack.forget()
        stack.turn()
        acting = False
        for place, (run, peers) in enumerate(active):
            if run.act(stack, place, columns, peers):
                acting = True
            else:
                stack.rest(place)
        if not acting:
            return
        here = self._signals.positions[columns]
        step = self.step = law.compose(stack, here)
        lead = self._control.lead
        advance(self.reference, columns, step.displacement, here, lead, lower, upper)

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
        """The active controllers' levels, and the union of their joints."""
        runs = tuple([item.run for item in active])
        found = self._compositions.get(runs)
        if found is None:
            joints = tuple(dict.fromkeys(joint for run in runs for joint in run.controller.joints))
            columns = self._signals.joints.pick(joints)
            limits, margin = self._signals.kinematics, self.settings.limit_margin
            lower, upper = limits.lower[columns], limits.upper[columns]
            law = Law(lower, upper, self.settings)
            stack = Stack([(run.controller.name, run.size) for run in runs], len(columns))
            found = _Composition(columns, lower + margin, upper - margin, law, stack)
            self._compositions[runs] = found
        return found
