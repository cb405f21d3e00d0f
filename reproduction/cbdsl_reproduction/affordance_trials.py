"""Trials of the affordances of a single object: a program that acts on it, rewarded or not."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from cbdsl_reproduction.constellation_trials import CHANNELS
from cbdsl_reproduction.simulation_fixture import simulation_fixture
from cbdsl_reproduction.trial_digest import trial_digest

STAGE = "one_of_three_things"
# Neither programs nor objects have a colon in their names, so that the text splits uniquely.
_BETWEEN = ":"


class AffordanceTrial(NamedTuple):
    """Episode of a program that acts on an object.

    Attributes:
        things: Program and object, as ``attempt`` joins them.
        seed: Seed of the episode.
        rewarded: True if the program was rewarded.
        ending: Ending of the program.
    """

    things: str
    seed: int
    rewarded: bool
    ending: str


def attempt(program: str, thing: str) -> str:
    """Return a program and the object that it acts on, as one text."""
    return f"{program}{_BETWEEN}{thing}"


def affordance_digest(pair: str) -> str:
    """Return the digest of all inputs of an attempt's trials except seed and engine."""
    program, _, thing = pair.partition(_BETWEEN)
    return trial_digest(program, {"feature": CHANNELS[thing]}, STAGE)


def run_affordances(
    pair: str, seeds: Iterable[int], engine: str, cameras: str | None
) -> Iterator[AffordanceTrial]:
    """Act on an object, once for each seed.

    Args:
        pair: Program and object, as ``attempt`` joins them.
        seeds: Seeds of the episodes.
        engine, cameras: Engine and cameras of the simulation.

    Raises:
        BackendError, EpisodeError: The simulator cannot run it.
        ImportError: The simulator is not installed.
    """
    program, _, thing = pair.partition(_BETWEEN)
    values = {"feature": CHANNELS[thing]}
    with simulation_fixture(program, values, STAGE, engine, cameras) as lab:
        runner = lab.runner()
        for seed in seeds:
            result = runner.run(lab.stage, seed, thing)
            yield AffordanceTrial(pair, seed, result.rewarded, result.ending)
