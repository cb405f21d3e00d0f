"""Explanations: why each level moved as it did in a tick, and what that did to its potential."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.law import LevelReport, Step
from cbdsl.control.level import Level
from cbdsl.runtime.controller_run import ControllerRun
from cbdsl.runtime.episode import Tick
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.types.potential import POTENTIALS

Floats = NDArray[np.float64]

#: What a level is held by where joints at their limits took its freedom.
LIMITS = "joint limits"

#: What a level is held by where its target is out of reach.
REACH = "reach"

# A level that achieves less of what it wants is asked who took the rest.
_SMALL_SHARE = 0.5
# A level that achieves more than this share is asked who pushes it on.
_LARGE_SHARE = 1.5
# Whoever responds to less of a level's velocity than this did not take it.
_TAKEN = 0.1
# Displacement of a task in a tick, in its unit, that is rounding: of less there is no share.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class LevelExplanation:
    """Why a level moved as it did.

    Attributes:
        name: the controller, qualified by the programs that use it.
        phi: its potential, NaN while undefined.
        share: as in ``LevelReport``; NaN where the level requests no displacement.
        rank, singular_value: as in ``LevelReport``.
        predicted: change of phi that the step of the tick before was to make by now, to first
            order; NaN where that is not known.
        measured: change of phi since the tick before; NaN where there was none.
        held_by: Level above, or ``LIMITS``, that takes most of its freedom; ``REACH`` if none does
            and it is at the nearest point to its target; empty otherwise.
        pushed_by: the level whose motion carries it further than it wants, if its share is far
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
        levels: highest priority first.
        at_limits: joints that their limits held back.
        guards: names of those that the motion gave way to.
    """

    levels: tuple[LevelExplanation, ...]
    at_limits: tuple[str, ...]
    guards: tuple[str, ...] = ()


class Explanation:
    """Explains the ticks of one episode, each compared with the one before."""

    def __init__(self) -> None:
        self._before: dict[str, tuple[float, float]] = {}

    def note(self, tick: Tick) -> TickExplanation:
        """Explain a tick; to be called once for each."""
        step = tick.actuation.step
        if step is None:
            self._before = {}
            return TickExplanation((), ())
        runs = [_run(tick.run, level.name) for level in step.levels]
        names = [name for name, _ in runs]
        others = [_others(step, place, names) for place in range(len(names))]
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
        guards = tick.actuation.load_guards.holding
        return TickExplanation(levels, tick.actuation.at_limits(), guards)

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
    """All controllers of a program and of the programs it uses, with qualified names."""
    for each in run.runs:
        yield prefix + each.controller.name, each
    for name, child in run.children.items():
        yield from named_runs(child, f"{prefix}{name}.")


def _run(program: ProgramRun, name: str) -> tuple[str, ControllerRun]:
    """The controller that a level belongs to: of several with its name, one that is active."""
    namesakes = [each for each in named_runs(program) if each[1].controller.name == name]
    return next((each for each in namesakes if each[1].predicate != "X"), namesakes[0])


def _change(run: ControllerRun, level: Level, displacement: Floats) -> float:
    """The change of phi that a displacement, rad, shape (n,), makes to first order."""
    kind = POTENTIALS[run.controller.potential]
    evaluation = None if kind.field else run.evaluate()
    if evaluation is None:
        return math.nan
    change = evaluation.jacobian @ displacement
    return -float(evaluation.residual @ change) if kind.residual else float(change[0])


def _legible(report: LevelReport, level: Level) -> LevelReport:
    """Return a report without a share where the level requests no displacement."""
    requested = float(np.linalg.norm(level.velocity))
    return replace(report, share=math.nan) if requested <= _ROUNDING else report


def _others(step: Step, place: int, names: Sequence[str]) -> tuple[str, str]:
    """Return the level that holds a level back, and the one that pushes it on; or nothing."""
    share = _legible(step.reports[place], step.levels[place]).share
    if share < _SMALL_SHARE:
        return _holder(step, place, names), ""
    return "", _pusher(step, place, names) if share > _LARGE_SHARE else ""


def _pusher(step: Step, place: int, names: Sequence[str]) -> str:
    """Whose own motion, as if it were alone, goes furthest in a level's wanted direction."""
    level = step.levels[place]
    pushed = {
        names[other]: float(
            level.velocity @ level.jacobian @ np.linalg.pinv(each.jacobian) @ each.velocity
        )
        for other, each in enumerate(step.levels)
        if other != place
    }
    pusher = max(pushed, key=lambda name: pushed[name], default="")
    return pusher if pusher and pushed[pusher] > 0 else ""


def _holder(step: Step, place: int, names: Sequence[str]) -> str:
    """Who took most of what a level would do if it were alone: a level above, or the limits."""
    level = step.levels[place]
    wish = np.linalg.pinv(level.jacobian) @ level.velocity
    size = float(wish @ wish)
    stuck = step.reports[place].stuck
    if size == 0.0:
        return REACH if stuck else ""
    taken = {
        names[above]: float(np.square(_projected(step.levels[above].jacobian, wish)).sum()) / size
        for above in range(place)
    }
    taken[LIMITS] = float(np.square(wish[step.locked]).sum()) / size
    holder = max(taken, key=lambda name: taken[name])
    if taken[holder] > _TAKEN:
        return holder
    return REACH if stuck else ""


def _projected(jacobian: Floats, displacement: Floats) -> Floats:
    """The part of a displacement, shape (n,), that a task of this Jacobian responds to."""
    part: Floats = np.linalg.pinv(jacobian) @ (jacobian @ displacement)
    return part
