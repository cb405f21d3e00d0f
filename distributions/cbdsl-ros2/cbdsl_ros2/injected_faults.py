"""Faults: intentional errors of a served robot, from a time on."""

from __future__ import annotations

import copy
import math
import os
import re
import signal
import time
from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

import numpy as np

from cbdsl.extend.driver import BackendError
from cbdsl_ros2 import dds_types as msg

#: Faults by name, each with its meaning.
KINDS = {
    "kill": "the process ends as by SIGKILL",
    "suspend": "the process stops as by SIGSTOP, until it gets SIGCONT",
    "stall": "the process does nothing for 200 ms, once",
    "loss": "30 percent of the states and commands are lost",
    "clock": "stamps jump by 10 s",
    "nan": "a position is NaN",
    "swap": "joints come in another order",
    "missing": "a joint is missing",
    "double": "a joint comes twice",
    "frozen": "states stay equal, with fresh stamps",
    "effort": "an effort is over its limit",
}
_SPEC = re.compile(r"(?P<kind>[a-z]+)@(?P<start>\d+(\.\d+)?)")
_LOSS, _STALL, _JUMP, _EFFORT = 0.3, 0.2, 10.0, 1e6


class InjectedFault(NamedTuple):
    """A kind of ``KINDS``, from some seconds after the start on."""

    kind: str
    start: float


def read_fault(text: str) -> InjectedFault:
    """Read a fault, such as ``nan@2.5``.

    Raises:
        BackendError: There is no such kind, or no time.
    """
    match = _SPEC.fullmatch(text)
    if match is None:
        raise BackendError(f"'{text}' is not a fault; write KIND@SECONDS, such as nan@2.5")
    if match["kind"] not in KINDS:
        raise BackendError.unknown("fault", match["kind"], KINDS)
    return InjectedFault(match["kind"], float(match["start"]))


class Faults:
    """Faults of a served robot.

    Args:
        faults: Faults, each from its time on.
        seed: Seed of lost messages.
        clock: Time, s.

    Attributes:
        begun: Wall time at which each fault began, s since the epoch, by kind.
    """

    def __init__(
        self,
        faults: Iterable[InjectedFault],
        seed: int = 0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._faults, self._clock = tuple(faults), clock
        self._rng, self._start = np.random.default_rng(seed), clock()
        self._frozen: msg.JointState | None = None
        self.begun: dict[str, float] = {}

    def restart(self) -> None:
        """Count the time from now on."""
        self._start = self._clock()

    def active(self, kind: str) -> bool:
        """Return whether a fault has begun."""
        elapsed = self._clock() - self._start
        acts = any(fault.kind == kind and elapsed >= fault.start for fault in self._faults)
        if acts:
            self.begun.setdefault(kind, time.time())
        return acts

    def stall(self) -> None:
        """Stop or end the process if such a fault is active."""
        if self.active("kill"):
            os.kill(os.getpid(), signal.SIGKILL)
        for kind in ("stall", "suspend"):
            # Once only: ``active`` stays true after its time.
            if kind not in self.begun and self.active(kind):
                if kind == "suspend":
                    os.kill(os.getpid(), signal.SIGSTOP)
                else:
                    time.sleep(_STALL)

    def loses(self) -> bool:
        """Return whether a message is lost."""
        return self.active("loss") and bool(self._rng.random() < _LOSS)

    def stamp(self, now: float) -> float:
        """Return the stamp of a measurement, s since the epoch."""
        return now + _JUMP if self.active("clock") else now

    def states(self, state: msg.JointState) -> Iterator[msg.JointState]:
        """Yield the messages that replace joint states."""
        if self.loses():
            return
        if self.active("frozen"):
            frozen = self._frozen = self._frozen or copy.deepcopy(state)
            yield msg.JointState(
                state.header, frozen.name, frozen.position, frozen.velocity, frozen.effort
            )
            return
        if self.active("nan"):
            state.position[0] = math.nan
        if self.active("effort"):
            state.effort = [_EFFORT] * len(state.name)
        yield self._reordered(state)

    def _reordered(self, state: msg.JointState) -> msg.JointState:
        """Return joint states with other joints, or in another order."""
        order = list(range(len(state.name)))
        if self.active("swap"):
            order.reverse()
        if self.active("missing"):
            order.pop()
        if self.active("double"):
            order.append(order[0])
        parts = (state.name, state.position, state.velocity, state.effort)
        picked = ([part[i] for i in order] if part else [] for part in parts)
        return msg.JointState(state.header, *picked)
