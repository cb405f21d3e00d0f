"""Explorations: rewards by Eq 6.2, habituation, choice of actions, and states of models."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.learning.catalogs.action_outcome import NOOP, ActionOutcome, FeatureForm
from cbdsl.learning.catalogs.catalog_exploration import CatalogConstants, CatalogExploration
from cbdsl.learning.catalogs.exploration import Exploration
from cbdsl.learning.catalogs.model_exploration import ModelConstants, ModelExploration

PLACE = (FeatureForm("place", "m", 3),)
ACTIONS = {"touch": PLACE, "lift": PLACE}
SEEN: Mapping[str, Mapping[str, tuple[float, ...]]] = {
    "touch": {"seen": (), "place": (0.5, 0.0, 0.0)},
    "lift": {"seen": ()},
}


def catalog(**constants: Any) -> CatalogExploration:
    return CatalogExploration(ACTIONS, CatalogConstants(**constants))


def touched(rng: np.random.Generator, spread: float = 0.05) -> ActionOutcome:
    place = tuple(rng.normal([0.5, 0.0, 0.0], spread).tolist())
    return ActionOutcome("touch", rewarded=True, features={"place": place})


def explored(
    exploration: Exploration, actions: int, rewarding: Mapping[str, float], seed: int = 0
) -> list[str]:
    """Run an exploration of a world with some rewarding actions; return the chosen actions."""
    rng, chosen = np.random.default_rng(seed), []
    for _ in range(actions):
        name = exploration.choose(rng)
        chosen.append(name)
        features: dict[str, tuple[float, ...]] = {}
        if name in rewarding:
            features["place"] = tuple(rng.normal([0.5, 0.0, 0.0], rewarding[name]).tolist())
        exploration.note(
            ActionOutcome(name, rewarded=name in rewarding, features=features, ahead=SEEN)
        )
    return chosen


def test_reward_is_the_change_relative_to_the_largest_until_then_minus_the_cost() -> None:
    rng, exploration = np.random.default_rng(5), catalog()
    steps = [exploration.note(touched(rng)) for _ in range(12)]
    assert steps[0].reward == pytest.approx(1 - 0.05)
    for index, step in enumerate(steps):
        largest = max(each.change for each in steps[: index + 1])
        assert step.reward == pytest.approx(step.change / largest - 0.05)


def test_failure_costs_and_noop_does_not() -> None:
    exploration = catalog(cost=0.2)
    assert exploration.note(ActionOutcome("lift")) == ("lift", False, 0.0, -0.2)
    assert exploration.note(ActionOutcome(NOOP)) == (NOOP, False, 0.0, 0.0)
    assert exploration.affordances["lift"].tried == 1


@pytest.mark.parametrize("seed", range(5))
def test_habituated_exploration_chooses_noop(seed: int) -> None:
    exploration = catalog()
    chosen = explored(exploration, 120, {"touch": 0.05}, seed)
    assert chosen[-30:].count(NOOP) > chosen[:30].count(NOOP)
    assert (exploration.change_of("touch") or 0.0) < 0.25


def test_exploration_is_not_over_before_each_action_was_tried() -> None:
    rng, exploration = np.random.default_rng(5), catalog(least=2)
    for _ in range(30):
        exploration.note(touched(rng, 0.001))
    assert not exploration.is_over
    for _ in range(2):
        exploration.note(ActionOutcome("lift"))
    assert exploration.is_over


def test_action_that_joins_is_attended_to() -> None:
    exploration, both = catalog(), {"touch": 0.05, "inspect": 0.05}
    explored(exploration, 100, both)
    exploration.add({"inspect": PLACE})
    later = explored(exploration, 20, both, seed=1)
    assert later.count("inspect") >= 5


def test_failed_action_is_left_out() -> None:
    exploration = catalog()
    exploration.note(ActionOutcome("lift", failed=True, ending="no hand"))
    assert "lift" not in explored(exploration, 50, {"touch": 0.05})


def test_action_whose_features_were_undefined_counts_and_teaches_nothing() -> None:
    rng, exploration = np.random.default_rng(5), catalog()
    exploration.note(touched(rng))
    before = exploration.affordances["touch"].model
    step = exploration.note(ActionOutcome("touch", rewarded=True))
    after = exploration.affordances["touch"].model
    assert before is not None and after is not None
    assert (step.change, after.variance(), after.tried) == (0.0, before.variance(), 2)


@pytest.mark.parametrize("kind", ["catalog", "models"])
@given(
    seed=st.integers(0, 1000),
    origin=st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    signs=st.tuples(*[st.sampled_from([-1.0, 1.0])] * 3),
    axes=st.permutations(range(3)),
)
def test_rewards_do_not_depend_on_the_origin_and_the_axes_of_the_frame(
    kind: str, seed: int, origin: tuple[float, ...], signs: tuple[float, ...], axes: list[int]
) -> None:
    """Mirror, shift and swap the axes of a random log: its rewards and predictions stay."""
    start: Any = {"catalog": catalog, "models": models}[kind]
    rng, frames = np.random.default_rng(seed), [start(), start()]
    middle, spread = rng.uniform(-1.0, 1.0, 3), rng.uniform(0.005, 0.2, 3)
    for _ in range(12):
        place = rng.normal(middle, spread)
        there = (np.array(signs) * (place - np.array(origin)))[axes]
        name, rewarded = ("touch", "lift")[rng.integers(2)], bool(rng.random() < 0.7)
        steps = []
        for exploration, seen in zip(frames, (place, there), strict=True):
            features = {"place": tuple(seen.tolist())}
            outcome = ActionOutcome(name, rewarded, features, ahead={name: features})
            steps.append(exploration.note(outcome))
        assert steps[1].reward == pytest.approx(steps[0].reward, abs=1e-6)
        one, other = (each.affordances[name].reward_probability() for each in frames)
        assert other == pytest.approx(one, abs=1e-6)
        assert frames[1].values == pytest.approx(frames[0].values, abs=1e-6)


def test_rewards_by_the_measure_of_the_source_depend_on_the_signs() -> None:
    rng, changes = np.random.default_rng(1), []
    place = rng.normal([0.5, 0.4, 0.3], 0.05)
    for sign in (1.0, -1.0):
        features = {"place": tuple((place * [1.0, sign, 1.0]).tolist())}
        outcome = ActionOutcome("touch", True, features)
        changes.append(catalog(measure="sum").note(outcome).change)
    assert changes[0] != pytest.approx(changes[1], rel=0.1)


def models(**constants: float) -> ModelExploration:
    return ModelExploration(ACTIONS, ModelConstants(**constants))


def test_states_have_one_letter_per_model() -> None:
    rng, exploration = np.random.default_rng(5), models()
    assert exploration.state == "XX"
    exploration.note(replace(touched(rng), ahead=SEEN))
    assert exploration.state == "0X"
    exploration.note(ActionOutcome("lift", ahead=SEEN))
    assert exploration.state == "00"
    for _ in range(20):
        exploration.note(replace(touched(rng, 0.01), ahead=SEEN))
    assert exploration.state == "10"
    exploration.note(ActionOutcome(NOOP, ahead={"touch": SEEN["touch"]}))
    assert exploration.state == "1-"


def test_moved_object_makes_its_model_changing_again() -> None:
    rng, exploration = np.random.default_rng(5), models()
    for _ in range(20):
        exploration.note(replace(touched(rng, 0.01), ahead=SEEN))
    assert exploration.state[0] == "1"
    moved: dict[str, Mapping[str, tuple[float, ...]]] = {
        "touch": {"seen": (), "place": (0.5, 0.25, 0.0)}
    }
    exploration.note(ActionOutcome(NOOP, ahead=moved))
    assert exploration.state[0] == "0"


def test_q_values_follow_the_update_rule() -> None:
    rng, exploration = np.random.default_rng(5), models(promise=0.0, alpha=0.5, gamma=0.5)
    first = exploration.note(replace(touched(rng), ahead=SEEN))
    assert exploration.table["XX"]["touch"] == pytest.approx(0.5 * first.reward)
    second = exploration.note(ActionOutcome("lift", ahead=SEEN))
    assert exploration.table["0X"]["lift"] == pytest.approx(0.5 * second.reward)
    # The best value in the state that it leads to counts for half.
    exploration.table["00"] = {"touch": 0.6, "lift": -1.0}
    third = exploration.note(replace(touched(rng), ahead=SEEN))
    expected = 0.6 + 0.5 * (third.reward + 0.5 * 0.6 - 0.6)
    assert exploration.table["00"]["touch"] == pytest.approx(expected)


@pytest.mark.parametrize("seed", range(3))
def test_model_program_habituates(seed: int) -> None:
    chosen = explored(models(), 160, {"touch": 0.05, "lift": 0.05}, seed)
    assert chosen[-30:].count(NOOP) >= 20 > chosen[:15].count(NOOP)


def test_outcomes_without_features_count_in_the_model() -> None:
    """Count a rewarded outcome, although the features of the model were not defined then."""
    touch = catalog().affordances["touch"]
    constants = CatalogConstants()
    touch.note(ActionOutcome("touch", rewarded=True), constants)
    touch.note(ActionOutcome("touch", features={"place": (0.9, 0.0, 0.0)}), constants)
    touch.note(touched(np.random.default_rng(1)), constants)
    model = touch.model
    assert model is not None
    assert (model.tried, model.successes) == (3, 2) == (touch.tried, touch.successes)
    assert (model.rewarded.weight, model.unrewarded.weight) == (1.0, 1.0)


def test_first_change_is_relative_to_itself() -> None:
    rng, exploration = np.random.default_rng(5), catalog(prior=1000.0)
    assert exploration.change_of("touch") is None
    first = exploration.note(touched(rng))
    assert 0 < first.change < 0.5
    assert first.reward == pytest.approx(1 - 0.05)
    second = exploration.note(touched(rng))
    assert second.change > first.change
    third = exploration.note(replace(touched(rng), features={"place": (0.4, 0.0, 0.0)}))
    assert exploration.change_of("touch") == pytest.approx(third.change / second.change)


def test_failure_changes_no_reward_and_leaves_the_change_of_the_last_success() -> None:
    rng, exploration = np.random.default_rng(5), catalog()
    first = exploration.note(touched(rng))
    place = {"place": (0.9, 0.0, 0.0)}
    assert exploration.note(ActionOutcome("touch", features=place)).change == 0.0
    assert exploration.affordances["touch"].change == first.change


def test_outcome_without_reward_changes_no_fresh_model() -> None:
    touch = catalog().affordances["touch"]
    assert touch.note(ActionOutcome("touch"), CatalogConstants()) == 0.0
    assert (touch.change, touch.distance()) == (None, 0.0)


def test_reward_probability_uses_counts_and_features() -> None:
    exploration, rng = catalog(), np.random.default_rng(1)
    touch = exploration.affordances["touch"]
    assert touch.reward_probability() == pytest.approx(1 / 2)
    exploration.note(ActionOutcome("touch", features={"place": (0.9, 0.0, 0.0)}))
    assert touch.reward_probability() == pytest.approx(1 / 3)
    for _ in range(4):
        exploration.note(touched(rng, 0.01))
    assert touch.model is not None
    assert touch.reward_probability() == pytest.approx(5 / 7) == touch.model.reward_probability
    assert touch.distance() == 0.0, "nothing is seen ahead"
    near, far = ({"touch": {"place": (x, 0.0, 0.0)}} for x in (0.5, 0.9))
    exploration.note(ActionOutcome(NOOP, ahead=near))
    assert 5 / 7 < touch.reward_probability() < 0.9, "few trials are no certainty"
    assert touch.distance() < 1
    exploration.note(ActionOutcome(NOOP, ahead=far))
    assert touch.reward_probability() < 0.5 and touch.distance() > 4
    unseen: dict[str, Mapping[str, tuple[float, ...]]] = {"touch": {"color": (1.0,)}}
    exploration.note(ActionOutcome(NOOP, ahead=unseen))
    assert touch.reward_probability() == pytest.approx(5 / 7) and touch.distance() == 0.0


def test_in_si_a_deviation_of_one_counts_as_much_as_the_prior() -> None:
    """Compare samples a unit apart: units of 1 have a tenth of the variance of 3 cm."""
    changes = {}
    for units, deviation in (("workspace", 0.03), ("si", 1.0)):
        exploration = CatalogExploration(ACTIONS, CatalogConstants(units=units, measure="sum"))
        exploration.note(ActionOutcome("touch", True, {"place": (0.6, 0.0, 0.0)}))
        model = exploration.affordances["touch"].model
        assert model is not None
        assert model.scale == pytest.approx(np.full(3, deviation))
        changes[units] = exploration.steps[0].change
    assert changes["workspace"] > changes["si"] > 0


def test_softmax_favours_by_the_ratio_of_exponentials() -> None:
    exploration = catalog(temperature=0.5, coldest=0.5)
    exploration.values = {"touch": 0.5, "lift": 0.0, NOOP: -10.0}
    rng = np.random.default_rng(2)
    chosen = [exploration.choose(rng) for _ in range(4000)]
    assert chosen.count("touch") / chosen.count("lift") == pytest.approx(np.e, rel=0.1)
    assert NOOP not in chosen


def test_exploration_cools_down_with_each_step_to_a_least_temperature() -> None:
    exploration = catalog(temperature=0.4, decay=0.5, coldest=0.15)
    assert exploration.temperature == pytest.approx(0.4)
    exploration.note(ActionOutcome(NOOP))
    assert exploration.temperature == pytest.approx(0.2)
    exploration.note(ActionOutcome(NOOP))
    assert exploration.temperature == pytest.approx(0.15)


def test_model_that_habituated_or_is_undefined_promises_nothing() -> None:
    exploration = models(promise=0.3)
    assert exploration.values == {NOOP: 0.0, "touch": 0.3, "lift": 0.3}
    exploration.note(ActionOutcome("lift", ahead={"touch": SEEN["touch"]}))
    assert exploration.state == "X-"
    assert exploration.values == {NOOP: 0.0, "touch": 0.3, "lift": 0.0}
