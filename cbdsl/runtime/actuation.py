"""From levels to joint references: the control law applied to what acts in a tick."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.law import Law, LawSettings, Level, Step
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.signals import Signals
from cbdsl.runtime.controller_run import ControllerRun
from cbdsl.runtime.program_run import Active

Floats = NDArray[np.float64]
Columns = NDArray[np.intp]


class _Body(NamedTuple):
    """The joints that act together.

    Attributes:
        columns: their indices among all actuated ones, shape (n,).
        lower: lower limits with their margin, rad, shape (n,).
        upper: upper limits with their margin, rad, shape (n,).
        law: of these joints.
    """

    columns: Columns
    lower: Floats
    upper: Floats
    law: Law


class Actuation:
    """Integrates the law's displacements into joint references.

    Attributes:
        reference: position references of all actuated joints, rad, shape (n,).
        levels: the levels of the last tick, highest priority first.
        step: what the law made of them, or ``None`` where nothing acted.
    """

    def __init__(self, robot: RobotDocument, signals: Signals, period: float) -> None:
        self._control = robot.control
        self._signals = signals
        self._settings = LawSettings(
            damping=robot.control.damping,
            singular_value=robot.control.singular_value,
            joint_step=robot.control.joint_speed * period,
            limit_margin=robot.control.limit_margin,
        )
        self._bodies: dict[tuple[ControllerRun, ...], _Body] = {}

    def reset(self, positions: Floats) -> None:
        """Start from measured positions, rad, shape (n,)."""
        self.reference = positions.copy()
        self.levels: Sequence[Level] = ()
        self.step: Step | None = None
        self._acting: _Body | None = None
        self._before: dict[ControllerRun, Floats] = {}

    def move(self, active: Sequence[Active]) -> None:
        """Evaluate the active controllers and move the references by the law's step."""
        self.levels, self.step = (), None
        # A program that has ended leaves nothing to act.
        if not active:
            self._acting = None
            return
        body = self._body(active)
        columns = body.columns
        found = [(item.run, item.run.evaluate(columns, item.peers)) for item in active]
        self.levels = self._midway(body, [(run, level) for run, level in found if level])
        if not self.levels:
            return
        here = self._signals.positions[columns]
        self.step = body.law.solve(self.levels, here)
        lead, reference = self._control.lead, self.reference[columns]
        wanted = reference + self.step.displacement
        # Without a bound on its lead, a blocked joint's reference would run away from it.
        wanted = np.minimum(np.maximum(wanted, here - lead), here + lead)
        # A joint that is past its margin comes back at the law's pace, not at once.
        lowest = np.minimum(body.lower, reference)
        highest = np.maximum(body.upper, reference)
        self.reference[columns] = np.minimum(np.maximum(wanted, lowest), highest)

    def at_limits(self) -> tuple[str, ...]:
        """The joints that their limits held back in the last tick."""
        if self.step is None or self._acting is None:
            return ()
        return tuple(
            self._signals.joints.names[column]
            for column, locked in zip(self._acting.columns, self.step.locked, strict=True)
            if locked
        )

    def _midway(self, body: _Body, levels: Sequence[tuple[ControllerRun, Level]]) -> list[Level]:
        """Levels with their Jacobians half a tick ahead, turning on as in the tick before.

        Jacobians of where a tick starts let a lower level move those above by the square of its
        step, tick after tick; those of its middle, by the cube, while it moves evenly.
        """
        before = self._before if body is self._acting else {}
        self._acting, self._before = body, {run: level.jacobian for run, level in levels}
        return [
            Level(level.name, 1.5 * level.jacobian - 0.5 * before[run], level.velocity)
            if run in before
            else level
            for run, level in levels
        ]

    def _body(self, active: Sequence[Active]) -> _Body:
        """The union of the active controllers' joints."""
        runs = tuple([item.run for item in active])
        body = self._bodies.get(runs)
        if body is None:
            joints = tuple(dict.fromkeys(joint for run in runs for joint in run.controller.joints))
            columns = self._signals.joints.pick(joints)
            limits, margin = self._signals.kinematics, self._settings.limit_margin
            lower, upper = limits.lower[columns], limits.upper[columns]
            law = Law(lower, upper, self._settings)
            body = self._bodies[runs] = _Body(columns, lower + margin, upper - margin, law)
        return body
