"""Impedance of two objects, measured by an episode of a program with tests."""

from __future__ import annotations

from typing import NamedTuple

from cbdsl import EpisodeResult
from cbdsl.api.learning import ImpedanceGauge, ImpedanceProfile
from cbdsl.api.sensing import Runner
from cbdsl_reproduction.simulation_fixture import SimulationFixture


class Measurement(NamedTuple):
    """Episode with the impedance that it measured.

    Attributes:
        profile: Profile of the completed tests; incomplete if the objects did not meet.
        result: Result of the episode.
    """

    profile: ImpedanceProfile
    result: EpisodeResult


def measure_impedance(
    fixture: SimulationFixture, runner: Runner, seed: int, context: str
) -> Measurement:
    """Run one episode in a context of the fixture's stage, and return its impedance profile.

    Raises:
        BackendError, EpisodeError: The simulator cannot run it.
    """
    # A new gauge for each episode, because a profile collects the tests of one episode.
    gauge = ImpedanceGauge(fixture.program)
    result = runner.run(fixture.stage, seed, context, observer=gauge)
    return Measurement(gauge.finish(runner.signals), result)
