"""Trials of what a thing affords by itself: a program that acts on it, rewarded or not."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from cbdsl.reproduction.constellation_trials import CHANNELS
from cbdsl.reproduction.simulation_fixture import simulation_fixture
from cbdsl.reproduction.trial_digest import trial_digest

STAGE = "one_of_three_things"
_BETWEEN = ":"


class AffordanceTrial(NamedTuple):
    """One episode.

    Attributes:
        things: the program and the thing, as ``attempt`` joins them.
        seed: of the episode.
        rewarded: whether the program was.
        ending: of the program.
    """

    things: str
    seed: int
    rewarded: bool
    ending: str


def attempt(program: str, thing: str) -> str:
    """A program that acts on a thing, as one text."""
    return f"{program}{_BETWEEN}{thing}"


def affordance_digest(what: str) -> str:
    """Digest of all that decides trials of an attempt beside seed and engine."""
    program, _, thing = what.partition(_BETWEEN)
    return trial_digest(program, {"feature": CHANNELS[thing]}, STAGE)


def run_affordances(
    what: str, seeds: Iterable[int], engine: str, cameras: str | None
) -> Iterator[AffordanceTrial]:
    """Act on a thing, once for each seed.

    Args:
        what: an attempt.
        seeds: of the episodes.
        engine, cameras: of the simulation.

    Raises:
        BackendError, EpisodeError: the simulator cannot run it.
        ImportError: it is not installed.
    """
    program, _, thing = what.partition(_BETWEEN)
    values = {"feature": CHANNELS[thing]}
    with simulation_fixture(program, values, STAGE, engine, cameras) as lab:
        runner = lab.runner()
        for seed in seeds:
            result = runner.run(lab.stage, seed, thing)
            yield AffordanceTrial(what, seed, result.rewarded, result.ending)
