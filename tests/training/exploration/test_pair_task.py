"""Pair task: a pair is rewarded where its program succeeds and nothing stayed far from its goal."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from cbdsl.backends.backend import BackendError
from cbdsl.checking.program import check_program
from cbdsl.learning.catalogs.action_outcome import ActionOutcome
from cbdsl.learning.catalogs.catalog_exploration import CatalogConstants
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.training.exploration.explorable_pair import ExplorablePair
from cbdsl.training.exploration.pair_task import PairTask, PairWork


class Ended:
    """A runner whose episode ends as given."""

    def __init__(self, outcome: str, far: tuple[str, ...]) -> None:
        self._outcome, self._far = outcome, far

    signals = None

    def run(self, *_: object, **__: object) -> EpisodeResult:
        return EpisodeResult(
            "stand", "pairs", "a_on_b", 1, False, (), (), 0, 1.0, 1.0, "", "an ending",
            outcome=self._outcome, far=self._far,
        )  # fmt: skip


class Refused:
    """A runner whose backend cannot set up the world."""

    signals = None

    def run(self, *_: object, **__: object) -> EpisodeResult:
        raise BackendError("there is no room")


@pytest.fixture
def task() -> PairTask:
    pair = ExplorablePair("a", "b", "a_on_b", check_program("posture"), cast(Any, None), {})
    given: dict[str, Any] = dict.fromkeys(PairTask.__dataclass_fields__)
    given |= {"pairs": {"a_on_b": pair}, "constants": CatalogConstants()}
    return PairTask(**given)


def act(task: PairTask, runner: object) -> ActionOutcome:
    """Return the outcome of the pair with a runner."""
    work = PairWork(task, cast(Any, SimpleNamespace(renderer="")), cast(Any, None))
    work._runners["a_on_b"] = cast(Any, runner)
    return work.act("a_on_b", 1)


@pytest.mark.parametrize(
    ("outcome", "far", "rewarded"),
    [
        ("success", (), True),
        ("success", ("above",), False),
        ("failure", (), False),
        ("", (), False),
    ],
)
def test_act_rewards_only_success_near_the_goal(
    task: PairTask, outcome: str, far: tuple[str, ...], rewarded: bool
) -> None:
    done = act(task, Ended(outcome, far))
    assert (done.rewarded, done.failed) == (rewarded, False)


def test_act_without_a_world_fails_unrewarded(task: PairTask) -> None:
    done = act(task, Refused())
    assert (done.rewarded, done.failed, done.ending) == (False, True, "there is no room")
