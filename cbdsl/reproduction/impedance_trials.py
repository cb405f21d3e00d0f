"""Trials of impedance: a pair of things brought together by a hand, and felt in twelve tests."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from cbdsl.learning.impedance import ImpedanceProfile
from cbdsl.reproduction.simulation_fixture import simulation_fixture
from cbdsl.reproduction.thing_pairs import ALL_PAIRS
from cbdsl.reproduction.trial_digest import trial_digest
from cbdsl.training.impedance_gauge import ImpedanceGauge

PROGRAM = "impedance"


class ImpedanceTrial(NamedTuple):
    """One episode.

    Attributes:
        things: name of the pair.
        seed: of the episode.
        profile: what was felt; not whole where the things did not come together.
        ending: of the program.
        sim_seconds: simulated.
    """

    things: str
    seed: int
    profile: ImpedanceProfile
    ending: str
    sim_seconds: float


def impedance_digest(name: str) -> str:
    """Digest of all that decides trials of a pair beside seed and engine."""
    pair = ALL_PAIRS[name]
    return trial_digest(PROGRAM, pair.values, pair.stage)


def run_trials(
    name: str, seeds: Iterable[int], engine: str, cameras: str | None
) -> Iterator[ImpedanceTrial]:
    """Feel one pair, once for each seed.

    Raises:
        BackendError, EpisodeError: the simulator cannot run it.
        ImportError: it is not installed.
    """
    pair = ALL_PAIRS[name]
    with simulation_fixture(PROGRAM, pair.values, pair.stage, engine, cameras) as lab:
        runner = lab.runner()
        for seed in seeds:
            gauge = ImpedanceGauge(lab.program)
            result = runner.run(lab.stage, seed, name, on_tick=gauge.note)
            profile = gauge.finish(runner.signals)
            yield ImpedanceTrial(name, seed, profile, result.ending, result.sim_seconds)
