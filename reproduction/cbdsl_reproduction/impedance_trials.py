"""Trials of impedance: a hand brings two objects together and runs twelve tests on them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from cbdsl.api.learning import ImpedanceProfile
from cbdsl_reproduction.impedance_measurement import measure_impedance
from cbdsl_reproduction.simulation_fixture import simulation_fixture
from cbdsl_reproduction.thing_pairs import ALL_PAIRS
from cbdsl_reproduction.trial_digest import trial_digest

PROGRAM = "impedance"


class ImpedanceTrial(NamedTuple):
    """Episode of impedance tests.

    Attributes:
        things: Name of the pair.
        seed: Seed of the episode.
        profile: Measured impedance; incomplete if the objects were not brought together.
        ending: Ending of the program.
        sim_seconds: Simulated time, s.
    """

    things: str
    seed: int
    profile: ImpedanceProfile
    ending: str
    sim_seconds: float


def impedance_digest(name: str) -> str:
    """Return the digest of all inputs of a pair's trials except seed and engine."""
    pair = ALL_PAIRS[name]
    return trial_digest(PROGRAM, pair.values, pair.stage)


def run_trials(
    name: str, seeds: Iterable[int], engine: str, cameras: str | None
) -> Iterator[ImpedanceTrial]:
    """Measure the impedance of one pair, once for each seed.

    Raises:
        BackendError, EpisodeError: The simulator cannot run it.
        ImportError: The simulator is not installed.
    """
    pair = ALL_PAIRS[name]
    with simulation_fixture(PROGRAM, pair.values, pair.stage, engine, cameras) as lab:
        runner = lab.runner()
        for seed in seeds:
            profile, result = measure_impedance(lab, runner, seed, name)
            yield ImpedanceTrial(name, seed, profile, result.ending, result.sim_seconds)
