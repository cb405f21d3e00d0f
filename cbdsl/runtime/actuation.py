"""From levels to joint references: the control law applied to what acts in a tick."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.law import Law, LawSettings, Level, Step
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.compiled import compiled_once
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


class _Tick(NamedTuple):
    """What acted in a tick: joints, controllers from the highest priority, and what they did."""

    body: _Body
    runs: tuple[ControllerRun, ...]
    step: Step

    def past(self, levels: Mapping[ControllerRun, Level]) -> Sequence[Floats]:
        """The levels' Jacobians in this tick and the one before, as far as known, (k, n) each.

        Where other levels acted, those of this tick, and of a level that had none its own.
        """
        if self.runs == tuple(levels):
            return self.step.rows, *self.step.past[:1]
        rows = dict(zip(self.runs, np.split(self.step.rows, self.step.ends[:-1]), strict=True))
        return (np.concatenate([rows.get(run, level.jacobian) for run, level in levels.items()]),)


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
        reference: position references of all actuated joints, rad, shape (n,).
        step: what the law made of the last tick's levels, or ``None`` where nothing acted.
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
        self.step: Step | None = None
        self._last: _Tick | None = None

    def move(self, active: Sequence[Active]) -> None:
        """Evaluate the active controllers and move the references by the law's step."""
        last, self._last, self.step = self._last, None, None
        # A program that has ended leaves nothing to act.
        if not active:
            return
        body = self._body(active)
        found = [(run, run.evaluate(body.columns, peers)) for run, peers in active]
        levels = {run: level for run, level in found if level is not None}
        if not levels:
            return
        here = self._signals.positions[body.columns]
        past = () if last is None or last.body is not body else last.past(levels)
        step = self.step = body.law.solve(list(levels.values()), here, past)
        self._last = _Tick(body, tuple(levels), step)
        advance(
            self.reference,
            body.columns,
            step.displacement,
            here,
            self._control.lead,
            body.lower,
            body.upper,
        )

    def at_limits(self) -> tuple[str, ...]:
        """The joints that their limits held back in the last tick."""
        if self._last is None:
            return ()
        body, _, step = self._last
        return tuple(
            self._signals.joints.names[column]
            for column, locked in zip(body.columns, step.locked, strict=True)
            if locked
        )

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
