"""Trials of stacks: objects set on each other by a hand, judged by the simulator's truth."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np

from cbdsl import UsageError
from cbdsl.api.sensing import EpisodeListeners, Tick
from cbdsl_reproduction.simulation_fixture import simulation_fixture
from cbdsl_reproduction.trial_digest import trial_digest

# Largest speed at rest, m/s; time to stand, time after the release in which the pace is measured,
# and period of a tick, s.
_STILL, _LONG, _JUST, _TICK = 0.01, 1.0, 0.2, 1 / 60


class StackTrial(NamedTuple):
    """Trial of a stack.

    Attributes:
        things: Context of the stage.
        seed: Seed of the episode.
        released: True if the topmost object was released on another one.
        stands: True if each object rests only on the one below, at least 1 s after the release.
        offset: Horizontal distance of the upper two centres at the release, m; NaN without.
        pace: Largest speed of the topmost object within 0.2 s of the release, m/s; NaN without.
        seconds: Time from the release to the end, s.
        ending: Ending of the program.
    """

    things: str
    seed: int
    released: bool
    stands: bool
    offset: float
    pace: float
    seconds: float
    ending: str


class StackJudge:
    """Judge of one episode by the simulator's ground truth, which no controller uses.

    Args:
        truth: Ground truth of the backend.
        order: Names of the objects, from below.
    """

    def __init__(self, truth: Any, order: tuple[str, ...]) -> None:
        if not hasattr(truth, "neighbours"):
            raise UsageError(
                "stacks are judged by contacts between objects, which this engine lacks: "
                "use --backend bullet or mujoco"
            )
        self._truth = truth
        self._order = order
        self._left, self._ticks = -1, 0
        self._lifted = False
        self._offset, self._pace = math.nan, 0.0

    def note(self, _: Tick) -> None:
        """Record a tick."""
        self._ticks += 1
        top, below = self._order[-1], self._order[-2]
        if self._truth.touched(top):
            # An object held clear of the table has been taken, and may be released.
            self._lifted |= "table" not in self._truth.neighbours(top)
            # A touch revokes an earlier release, so that only the last release counts.
            self._left, self._pace = -1, 0.0
            return
        if not self._lifted:
            return
        if self._left < 0:
            self._left = self._ticks
            centres = [self._truth.pose(name).position for name in (top, below)]
            self._offset = math.dist(centres[0][:2], centres[1][:2])
        if (self._ticks - self._left) * _TICK <= _JUST:
            speed = float(np.linalg.norm(self._truth.velocity(top)))
            self._pace = max(self._pace, speed)

    def conclude(self, stack: str, seed: int, ending: str) -> StackTrial:
        """Return the finished trial."""
        released = self._left >= 0
        seconds = (self._ticks - self._left) * _TICK if released else 0.0
        stands = released and seconds >= _LONG and self._stands()
        pace = self._pace if released else math.nan
        return StackTrial(stack, seed, released, stands, self._offset, pace, seconds, ending)

    def _stands(self) -> bool:
        """Return whether each object rests, and touches only the objects below and above."""
        # The lowest object also touches the table; the topmost one has no object above it.
        around = ("table", *self._order, None)
        for place, name in enumerate(self._order, start=1):
            beside = {each for each in (around[place - 1], around[place + 1]) if each}
            moves = float(np.linalg.norm(self._truth.velocity(name))) >= _STILL
            if moves or self._truth.touched(name) or set(self._truth.neighbours(name)) != beside:
                return False
        return True


def stack_digest(stack: str) -> str:
    """Return the digest of all inputs of a stack's trials except seed and engine."""
    program, stage, _ = _parts(stack)
    return trial_digest(program, {}, stage)


def _parts(stack: str) -> tuple[str, str, tuple[str, ...]]:
    """Return program and stage of a stack, and its objects from below."""
    if stack.count("_on_") > 1:
        return "stack_three", "stacks_of_three", ("base", "middle", "top")
    return "stack", "stacks", ("base", "top")


def run_stacks(
    stack: str, seeds: Iterable[int], engine: str, cameras: str | None
) -> Iterator[StackTrial]:
    """Build one stack, once for each seed.

    Args:
        stack: Context of the stage ``stacks`` or ``stacks_of_three``.
        seeds: Seeds of the episodes.
        engine, cameras: Engine and cameras of the simulation.

    Raises:
        BackendError, EpisodeError: The simulator cannot run it.
        ImportError: The simulator is not installed.
    """
    program, stage, order = _parts(stack)
    with simulation_fixture(program, None, stage, engine, cameras) as lab:
        runner = lab.runner()
        for seed in seeds:
            judge = StackJudge(lab.backend.truth, order)
            result = runner.run(
                lab.stage, seed, stack, observer=EpisodeListeners(on_tick=judge.note)
            )
            yield judge.conclude(stack, seed, result.ending)
