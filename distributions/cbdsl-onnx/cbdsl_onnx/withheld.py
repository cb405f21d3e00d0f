"""Way that a network asks for and its feedback does not go: held back by guards or limits."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.extend.document import ModelSignal, Resource
from cbdsl.extend.source import Reading, Signals
from cbdsl_onnx.plan import NetworkPlan

#: Time over which ways are compared, s.
WINDOW = 0.5


class _Sample(NamedTuple):
    """Feedback and reference of a network at a time, s, and its way asked for until then, m."""

    time: float
    here: NDArray[np.float64]
    goal: NDArray[np.float64]
    asked: NDArray[np.float64]


def reader(signal: ModelSignal, signals: Signals) -> Callable[[], Reading | None]:
    """Return the reader of the distance, called in every tick in which it is needed."""
    assert isinstance(signal.data, NetworkPlan)
    feedback, reference = signal.features
    return Withheld(signal.data.output.gives == "velocity", feedback, reference, signals)


class Withheld:
    """Distance between the place that a network asked for half a second ago, and the place now.

    Velocities add up to the place asked for. A target or a displacement is that place itself, so
    that the distance includes the lag of the controller. Undefined while the network is.

    Args:
        is_velocity: True if the reference is a place one second ahead.
        feedback: Position that the network moves.
        reference: Signal of the network.
        signals: Signals of the robot.
    """

    def __init__(
        self, is_velocity: bool, feedback: Resource, reference: Resource, signals: Signals
    ) -> None:
        self._is_velocity, self._signals = is_velocity, signals
        self._feedback, self._reference = feedback, reference
        for each in (feedback, reference):
            signals.bind(each)
        self._tick, self._samples = 0, deque[_Sample]()

    def __call__(self) -> Reading | None:
        tick = int(self._signals.clock[0])
        if tick != self._tick:
            if tick != self._tick + 1:  # the network begins again
                self._samples.clear()
            self._tick = tick
            self._note(self._signals.time)
        if not self._samples:
            return None
        first, last = self._samples[0], self._samples[-1]
        asked = first.here + last.asked - first.asked if self._is_velocity else first.goal
        return Reading(np.array([np.linalg.norm(asked - last.here)]), None, tick)

    def _note(self, now: float) -> None:
        here, goal = map(self._signals.read, (self._feedback, self._reference))
        if here is None or goal is None:
            self._samples.clear()
            return
        asked = np.zeros_like(here.value)
        if self._samples:
            last = self._samples[-1]
            asked = last.asked + (now - last.time) * (last.goal - last.here)
        self._samples.append(_Sample(now, here.value, goal.value, asked))
        while self._samples[0].time < now - WINDOW:
            self._samples.popleft()
