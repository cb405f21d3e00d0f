"""Tally of episodes: a repeated seed counts once."""

from __future__ import annotations

import pytest

from cbdsl.cli.episodes.episode_tally import EpisodeTally
from cbdsl.runtime.episode_result import EpisodeResult


@pytest.mark.parametrize("times", [1, 3])
def test_tally_counts_a_repeated_episode_by_its_last_run(times: int) -> None:
    tally = EpisodeTally()
    tally.add(_ended("success"))
    tally.add(_ended("failure"))
    for _ in range(times):
        tally.add(_ended("success"), again=True)
    assert +tally.outcomes == {"success": 2}
    assert tally.sim_seconds == pytest.approx(2 * _ended("success").sim_seconds)
    assert tally.summary(states_success=True).startswith("2 of 2 episodes succeeded")


def _ended(outcome: str) -> EpisodeResult:
    return EpisodeResult("", "", "", 0, False, (), (), 0, 1.5, 1.0, "", "", outcome)
