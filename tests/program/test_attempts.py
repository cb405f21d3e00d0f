"""Attempts end with reward, with failure, or with an action that needs no allocation."""

from __future__ import annotations

from cbdsl.program.attempts import Attempt, AttemptProgress, attempts
from cbdsl.program.transition import Transition

WORTH = {"XX": 0.3, "0-": 0.4, "00": 0.6, "11": 1.0, "1-": 0.1}


def step(
    before: str, after: str, allocation: str, reward: int = 0, place: float = 0.0
) -> Transition:
    action = f"reach with {allocation}" if allocation else "look"
    features = {"x": place}
    return Transition("p", 0, 1.0, before, action, after, 5, reward, (), allocation, features)


def test_progress_goes_on_with_the_features_of_its_beginning() -> None:
    episode = [
        step("XX", "0-", "left", place=1.0),
        step("0-", "00", "left", place=2.0),
        step("00", "11", "left", 1, place=3.0),
    ]
    assert list(attempts(episode, WORTH)) == [Attempt("left", {"x": 1.0}, True)]


def test_step_to_a_worse_state_ends_the_attempt() -> None:
    episode = [
        step("XX", "0-", "left", place=1.0),
        step("0-", "1-", "left", place=2.0),
        step("1-", "0-", "right", place=3.0),
        step("0-", "11", "right", 1),
    ]
    assert list(attempts(episode, WORTH)) == [
        Attempt("left", {"x": 1.0}, False),
        Attempt("right", {"x": 3.0}, True),
    ]


def test_same_allocation_after_a_failure_is_another_attempt() -> None:
    episode = [step("0-", "1-", "left", place=1.0), step("1-", "11", "left", 1, place=2.0)]
    assert [each.rewarded for each in attempts(episode, WORTH)] == [False, True]


def test_action_without_allocation_ends_an_attempt() -> None:
    episode = [step("XX", "0-", "left"), step("0-", "00", ""), step("00", "11", "", 1)]
    assert list(attempts(episode, WORTH)) == [Attempt("left", {"x": 0.0}, False)]


def test_episode_that_ends_amid_an_attempt_was_not_rewarded() -> None:
    assert list(attempts([step("XX", "0-", "left")], WORTH)) == [Attempt("left", {"x": 0.0}, False)]


def test_unchanged_state_fails_and_unknown_states_have_no_value() -> None:
    for before, after, fails in (("00", "00", True), ("00", "1-", True), ("--", "00", False)):
        assert AttemptProgress(WORTH).fails(before, after) == fails


def test_one_loss_of_sight_is_no_failure() -> None:
    progress = AttemptProgress(WORTH)
    steps = [("XX", "00"), ("00", "--"), ("--", "00"), ("00", "--")]
    assert [progress.fails(*each) for each in steps] == [False, False, False, True]


def test_ground_may_be_lost_once() -> None:
    progress = AttemptProgress(WORTH)
    steps = [("XX", "00"), ("00", "0-"), ("0-", "00"), ("00", "0-")]
    assert [progress.fails(*each) for each in steps] == [False, False, False, True]


def test_state_left_by_the_last_attempt_is_no_loss() -> None:
    progress = AttemptProgress(WORTH)
    steps = [("00", "0-"), ("0-", "00"), ("00", "0-"), ("0-", "00")]
    assert not any(progress.fails(*each) for each in steps)
    progress.begin()
    assert progress.fails("00", "1-")
