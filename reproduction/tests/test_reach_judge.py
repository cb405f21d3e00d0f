"""Verdicts of the judge of reach on episodes of a schema."""

from __future__ import annotations

import pytest

from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl_reproduction.judges.reach import verdict_on

REFUSED = "Not rewarded after 0.0 s in state XXX: reachtouch: reward is unlikely here (1 %)."
UNSEEN = "Not rewarded after 9.0 s in state X--: reachtouch: searchtrack has failed."
FAILED = "Not rewarded after 94.6 s in state 1XX: reachtouch: every allocation has been tried."


def episode(ending: str, *, rewarded: bool = False) -> EpisodeResult:
    return EpisodeResult(
        "reachtouch", "reach_on_all_sides", "far", 7, rewarded, (), (), 60, 1.0, 1.0, "", ending
    )


@pytest.mark.parametrize(
    ("result", "alone", "right"),
    [
        (episode("Rewarded.", rewarded=True), None, True),
        (episode(FAILED), None, False),
        (episode(REFUSED), {"right_arm": False, "left_arm": False}, True),
        (episode(REFUSED), {"right_arm": False, "left_arm": True}, False),
        (episode(UNSEEN), None, None),
    ],
)
def test_verdict_compares_the_prediction_with_all_allocations(
    result: EpisodeResult, alone: dict[str, bool] | None, right: bool | None
) -> None:
    verdict = verdict_on(result, 0.0, alone, touched=result.rewarded)
    assert verdict.outcomes["right"] is right
    assert verdict.outcomes["not found"] is (right is None)
    if right is not None:
        assert verdict.outcomes["refused"] is (alone is not None)


@pytest.mark.parametrize(("moved", "expected"), [(0.0, False), (0.1, True)])
def test_verdict_counts_motion_before_a_refusal(moved: float, expected: bool) -> None:
    verdict = verdict_on(episode(REFUSED), moved, {"right_arm": False}, touched=False)
    assert verdict.outcomes["moved before a refusal"] is expected
    assert (
        verdict_on(episode("", rewarded=True), 1.0, None, touched=True).outcomes[
            "moved before a refusal"
        ]
        is False
    )


def test_verdict_on_a_reward_without_touch_is_wrong() -> None:
    outcomes = verdict_on(episode("", rewarded=True), 0.0, None, touched=False).outcomes
    assert outcomes["right"] is False
    assert outcomes["rewarded without touch"] is True
