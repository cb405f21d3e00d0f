"""Stability: the episode after which a policy stays the same."""

from __future__ import annotations

import pytest
from drawn_experience import experience

from cbdsl.training.trial import Trial
from cbdsl_reproduction.chapter_4.stability import stable_after, stable_claim, stable_quantity
from cbdsl_reproduction.region import above
from cbdsl_reproduction.series import SEQUENTIAL
from tests.training.toy import ToyEpisodeRunner, toy_trial


@pytest.fixture(scope="module")
def trial() -> Trial:
    found, classroom = toy_trial(), ToyEpisodeRunner()
    for _ in range(40):
        found.run(classroom)
    return found


def test_policy_equals_its_final_choice_from_the_stable_episode_on(trial: Trial) -> None:
    again, chosen = toy_trial(), []
    for each in trial.experiences:
        again.replay(each)
        chosen.append(again.learner.greedy())
    found = set()
    for state in trial.learner.greedy():
        after = stable_after(trial, [experience((state, "some", "other"))])
        found.add(after)
        assert all(each.get(state) == chosen[-1].get(state) for each in chosen[after - 1 :])
        if after > 1:
            assert chosen[after - 2].get(state) != chosen[-1].get(state)
    assert len(found) > 1
    often = [experience(*((state, "some", "other") for state in trial.learner.greedy()))]
    assert stable_after(trial, often) == max(found)


def test_rarely_met_state_is_ignored(trial: Trial) -> None:
    known = trial.learner.greedy()
    states = {state: stable_after(trial, [experience((state, "", ""))]) for state in known}
    late, early = max(states, key=lambda s: states[s]), min(states, key=lambda s: states[s])
    assert states[early] < states[late]
    met = [experience(*[(early, "", "")] * 19, (late, "", ""))]
    assert stable_after(trial, met) == states[early]
    assert stable_after(trial, [*met, experience((late, "", ""))]) == states[late]


def test_quantity_is_the_median() -> None:
    claim = stable_claim("", SEQUENTIAL, "some", above(0))
    found = stable_quantity(claim, [3, 9, 8], seed=0)
    assert found.ours == 8 and found.note == "3 to 9" and found.interval is not None
    assert stable_quantity(claim, [4], seed=0).interval is None
