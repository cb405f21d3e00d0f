"""Injected causes of failures, for the development and the judgement of ``cb why``."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

from injected_faults import DelayedReadings, Distortion, NoisyReadings, WorldFault

from cbdsl.backends.simulated_backend import SimulatedBackend

Edits = Mapping[str, Sequence[tuple[str, str]]]


class Injection(NamedTuple):
    """Injected cause of a failure.

    Attributes:
        kind: Expected kind of the first cause; empty for a cause that is not on the list.
        program: Name of the program.
        edits: Replacements in the texts of programs and stages, by their names.
        fault: Fault of world or backend, if any.
        stage: Name of the stage; empty for the program's.
        name: Name of a cause that is not on the list.
        robot: Name of the robot; empty for the first one that fits.
    """

    kind: str
    program: str
    edits: Edits = MappingProxyType({})
    fault: Callable[[SimulatedBackend[Any]], WorldFault] | None = None
    stage: str = ""
    name: str = ""
    robot: str = ""

    @property
    def title(self) -> str:
        """Name of the cause, or its kind."""
        return self.name or self.kind


def late(key: str, ticks: int) -> Callable[[SimulatedBackend[Any]], WorldFault]:
    """Return the fault of one kind of readings that arrives some ticks, or exposures, late."""
    return lambda backend: Distortion(DelayedReadings(key, ticks), backend)


def noisy(key: str, deviation: float) -> Callable[[SimulatedBackend[Any]], WorldFault]:
    """Return the fault of one kind of readings with noise of some standard deviation."""
    return lambda backend: Distortion(NoisyReadings(key, deviation), backend)


def unlisted(
    name: str,
    program: str,
    edits: Edits = MappingProxyType({}),
    fault: Callable[[SimulatedBackend[Any]], WorldFault] | None = None,
) -> Injection:
    """Return an injection of a cause that is not on the list of ``cb why``."""
    return Injection("", program, edits, fault, name=name)
