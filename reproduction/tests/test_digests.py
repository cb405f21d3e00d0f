"""Small runs of experiments, whose outcomes only intended changes may change."""

from __future__ import annotations

from pathlib import Path

import pytest
from small_runs import LONG, digest, processor, recorded

from cbdsl_reproduction.registry import EXPERIMENTS

PROCESSOR, DIGESTS = recorded()


def test_recorded_digests_are_of_short_experiments() -> None:
    assert DIGESTS and DIGESTS.keys() <= EXPERIMENTS.keys() - LONG


@pytest.mark.slow
@pytest.mark.skipif(processor() != PROCESSOR, reason=f"the digests are of a {PROCESSOR}")
@pytest.mark.parametrize("name", DIGESTS)
def test_small_run_of_an_experiment_equals_the_recorded_one(name: str, tmp_path: Path) -> None:
    """Record it again with small_runs.py if its results were meant to change."""
    assert digest(name, tmp_path) == DIGESTS[name]
