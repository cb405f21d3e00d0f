"""Composer: manual changes to the gains, references and stack of a running program."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from cbdsl.diagnostics.nearest import suggestion
from cbdsl.runtime.controllers.controller_run import ControllerRun
from cbdsl.runtime.explanation import named_runs
from cbdsl.runtime.program_run import ProgramRun

# Largest coordinate of a target, m; no robot reaches farther.
_FARTHEST = 100.0


class ComposerError(Exception):
    """Error of a change that cannot be made; the message gives the reason."""


class Composer:
    """Manual changes to a running program, which persist across its episodes.

    Controllers keep their names; in programs used as actions, the action's name qualifies them.
    Only the main program's controllers can be composed.

    Attributes:
        gains: Changed gains, 1/s, by controller.
        targets: Positions held in place of references, m, shape (3,), by controller.
        stack: Names of the controllers that replace the program's actions, highest priority first;
            ``None`` while the program chooses its actions.
    """

    def __init__(self) -> None:
        self.gains: dict[str, float] = {}
        self.targets: dict[str, tuple[float, ...]] = {}
        self.stack: tuple[str, ...] | None = None
        self._run: ProgramRun | None = None

    def begin(self, run: ProgramRun) -> None:
        """Apply the changes to the run of an episode that has begun."""
        self._run = run
        runs = dict(named_runs(run))  # an edited program may lack some
        self.gains = {name: gain for name, gain in self.gains.items() if name in runs}
        self.targets = {name: goal for name, goal in self.targets.items() if name in runs}
        for name, gain in self.gains.items():
            runs[name].gain = gain
        for name, target in self.targets.items():
            runs[name].hold_reference(np.array(target))
        if self.stack is not None:
            run.compose(self.stack)

    @property
    def own(self) -> tuple[str, ...]:
        """Controllers that can be composed: those of the program's actions and background."""
        return tuple(run.controller.name for run in self._running.runs)

    @property
    def acting(self) -> tuple[str, ...]:
        """Composable controllers that act now above the background, highest priority first."""
        run = self._running
        return tuple(
            each.run.controller.name
            for each in run.active()
            if each.run in run.runs and each.run not in run.background
        )

    def set_gain(self, name: str, gain: float) -> float:
        """Change a controller's gain.

        Returns:
            Gain, 1/s.

        Raises:
            ComposerError: If the controller is unknown, or its gain cannot have this value.
        """
        run = self._named(name)
        if run.controller.tip_stiffness is not None:
            raise ComposerError(f"{name}: its gain is one of the tip's speed by force, and stays")
        if not 0 < gain <= run.largest_gain:
            most = f"{run.largest_gain:g} /s, which takes its error to 0 within a tick"
            raise ComposerError(f"{name}: a gain is above 0 and at most {most}, not {gain:g} /s")
        run.gain = self.gains[name] = gain
        return gain

    def hold(self, name: str, target: Sequence[float] | None) -> None:
        """Hold a position as a controller's reference, or restore its own reference.

        Args:
            name: Name of the controller.
            target: Position, m, shape (3,), world frame; ``None`` for the controller's own
                reference.

        Raises:
            ComposerError: If the controller is unknown, or has no position to hold.
        """
        run = self._named(name)
        if not run.can_hold:
            raise ComposerError(f"{name}: only constant or sensed positions can be held elsewhere")
        if target is None:
            self.targets.pop(name, None)
            run.hold_reference(None)
            return
        if len(target) != 3 or not all(abs(value) <= _FARTHEST for value in target):
            raise ComposerError(f"{name}: a target is three numbers, m, each within {_FARTHEST:g}")
        self.targets[name] = tuple(float(value) for value in target)
        run.hold_reference(np.array(self.targets[name]))

    def compose(self, names: Sequence[str] | None) -> None:
        """Replace the program's actions by a stack of controllers.

        Args:
            names: Controllers, highest priority first; ``None`` returns the choice to the program.

        Raises:
            ComposerError: If a name is unknown or repeated, or no name is given.
        """
        if names is not None:
            if not names or len(set(names)) != len(names):
                raise ComposerError("a stack is of at least one controller, each of them once")
            for name in names:
                if name not in self.own:
                    raise ComposerError(_unknown(name, self.own))
        self._running.compose(names)
        self.stack = None if names is None else tuple(names)

    def positions(self) -> Mapping[str, list[float]]:
        """Return the active controllers' references that can be held elsewhere, m, by name."""
        return {
            name: run.reference.tolist()
            for name, run in named_runs(self._running)
            if run.predicate != "X" and run.can_hold and np.isfinite(run.reference).all()
        }

    @property
    def _running(self) -> ProgramRun:
        if self._run is None:
            raise ComposerError("no episode has begun")
        return self._run

    def _named(self, name: str) -> ControllerRun:
        runs = dict(named_runs(self._running))
        if name not in runs:
            raise ComposerError(_unknown(name, runs))
        return runs[name]


def _unknown(name: str, known: Sequence[str] | Mapping[str, object]) -> str:
    return f"unknown controller '{name}'{suggestion(name, known)} (known: {', '.join(known)})"
