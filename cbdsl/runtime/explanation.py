"""Explanations: why each level moved as it did in a tick, and the effect on its potential."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cbdsl.control.law import LevelReport, Step
from cbdsl.control.level import Level
from cbdsl.numeric.arrays import Floats
from cbdsl.runtime.causes import Balance
from cbdsl.runtime.controllers.controller_run import ControllerRun
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.runtime.tick import Tick
from cbdsl.types.potential import POTENTIALS

# Share of the requested displacement below which the blocking level is reported.
_SMALL_SHARE = 0.5
# Share of the requested displacement above which the pushing level is reported.
_LARGE_SHARE = 1.5
# Displacement of a task in a tick, in its unit, that is rounding; below it no share is defined.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class LevelExplanation:
    """Reason for a level's motion.

    Attributes:
        name: Name of the controller, qualified by the programs that use it.
        phi: Potential, NaN while undefined.
        share: Share as in ``LevelReport``; NaN if the level requests no displacement.
        rank, singular_value: Numbers as in ``LevelReport``.
        predicted: Change of phi by now that the last tick's step predicts to first order; NaN if
            unknown.
        measured: Change of phi since the last tick; NaN in the first.
        held_by: Higher level or ``causes.LIMITS`` that takes most of this level's freedom;
            ``causes.OPTIMUM`` or ``causes.SINGULAR`` if no motion brings it nearer; else empty.
        pushed_by: Level whose motion carries this level beyond its request, if the share is far
            above 1; empty otherwise.
    """

    name: str
    phi: float
    share: float
    rank: int
    singular_value: float
    predicted: float
    measured: float
    held_by: str
    pushed_by: str = ""


@dataclass(frozen=True)
class TickExplanation:
    """Levels that acted in a tick.

    Attributes:
        levels: Explanations of the levels, highest priority first.
        at_limits: Joints held back by their limits.
        guards: Names of the guards that limited the motion.
        distances: Clauses about the distances of links that were read.
    """

    levels: tuple[LevelExplanation, ...]
    at_limits: tuple[str, ...]
    guards: tuple[str, ...] = ()
    distances: tuple[str, ...] = ()


class Explanation:
    """Explainer of the ticks of one episode, each compared with the last."""

    def __init__(self) -> None:
        self._before: dict[str, tuple[float, float]] = {}

    def note(self, tick: Tick) -> TickExplanation:
        """Explain a tick; call this once a tick."""
        step = tick.actuation.step
        if step is None:
            self._before = {}
            return TickExplanation((), ())
        runs = [_run(tick.run, level.name) for level in step.levels]
        names = [name for name, _ in runs]
        balance = tick.actuation.balance(names)
        assert balance is not None
        others = [_others(balance, place) for place in range(len(names))]
        levels = tuple(
            self._level(name, run, _legible(report, level), *by)
            for (name, run), report, level, by in zip(
                runs, step.reports, step.levels, others, strict=True
            )
        )
        self._before = {
            name: (run.phi, _change(run, level, step.displacement))
            for (name, run), level in zip(runs, step.levels, strict=True)
        }
        actuation = tick.actuation
        guards = (*actuation.load_guards.holding, *actuation.clearance.holding)
        distances = tick.signals.distances.clauses
        return TickExplanation(levels, actuation.at_limits(), guards, distances)

    def _level(
        self, name: str, run: ControllerRun, report: LevelReport, held_by: str, pushed_by: str
    ) -> LevelExplanation:
        phi, predicted = self._before.get(name, (math.nan, math.nan))
        return LevelExplanation(
            name,
            run.phi,
            report.share,
            report.rank,
            report.singular_value,
            predicted,
            run.phi - phi,
            held_by,
            pushed_by,
        )


def named_runs(run: ProgramRun, prefix: str = "") -> Iterator[tuple[str, ControllerRun]]:
    """Yield all controllers of a program and its subprograms, with qualified names."""
    for each in run.runs:
        yield prefix + each.controller.name, each
    for name, child in run.children.items():
        yield from named_runs(child, f"{prefix}{name}.")


def _run(program: ProgramRun, name: str) -> tuple[str, ControllerRun]:
    """Return the run that a level belongs to; an active one is preferred among namesakes."""
    namesakes = [each for each in named_runs(program) if each[1].controller.name == name]
    return next((each for each in namesakes if each[1].predicate != "X"), namesakes[0])


def _change(run: ControllerRun, level: Level, displacement: Floats) -> float:
    """Return the change of phi by a displacement, rad, shape (n,), to first order."""
    kind = POTENTIALS[run.controller.potential]
    evaluation = None if kind.field else run.evaluate()
    if evaluation is None:
        return math.nan
    # For a residual r the potential is r'r / 2, and J is the Jacobian of the task coordinates. As r
    # is the reference minus the feedback, the change of phi is -r'J dq. Otherwise J is the gradient
    # itself.
    change = evaluation.jacobian @ displacement
    return -float(evaluation.residual @ change) if kind.residual else float(change[0])


def _legible(report: LevelReport, level: Level) -> LevelReport:
    """Return a report whose share is NaN if the level requests no displacement."""
    requested = float(np.linalg.norm(level.velocity))
    return replace(report, share=math.nan) if requested <= _ROUNDING else report


def _others(balance: Balance, place: int) -> tuple[str, str]:
    """Return the cause that holds a level back and the level that pushes it, or empty names."""
    step = balance.step
    share = _legible(step.reports[place], step.levels[place]).share
    if share < _SMALL_SHARE:
        cause = balance.cause(place)
        return "" if cause is None else cause.holder, ""
    return "", _pusher(step, place, balance.names) if share > _LARGE_SHARE else ""


def _pusher(step: Step, place: int, names: Sequence[str]) -> str:
    """Return the level whose own motion goes furthest along a level's requested velocity."""
    level = step.levels[place]
    # Another level by itself moves the joints by its pseudoinverse times its task velocity. The
    # product is the motion that this causes along the requested velocity of this level.
    pushed = {
        names[other]: float(
            level.velocity @ level.jacobian @ np.linalg.pinv(each.jacobian) @ each.velocity
        )
        for other, each in enumerate(step.levels)
        if other != place
    }
    pusher = max(pushed, key=lambda name: pushed[name], default="")
    return pusher if pusher and pushed[pusher] > 0 else ""
