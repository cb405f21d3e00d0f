"""Explorations: rewards by Eq 6.2, habituation, choice of actions, and states of models."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from cbdsl.learning.action_outcome import NOOP, ActionOutcome, FeatureForm
from cbdsl.learning.catalog_exploration import CatalogConstants, CatalogExploration
from cbdsl.learning.exploration import Exploration
from cbdsl.learning.model_exploration import ModelConstants, ModelExploration

PLACE = (FeatureForm("place", "m", 3),)
ACTIONS = {"touch": PLACE, "lift": PLACE}
SEEN: Mapping[str, Mapping[str, tuple[float, ...]]] = {
    "touch": {"seen": (), "place": (0.5, 0.0, 0.0)},
    "lift": {"seen": ()},
}


def catalog(**constants: float) -> CatalogExploration:
    return CatalogExploration(ACTIONS, CatalogConstants(**constants))


def touched(rng: np.random.Generator, spread: float = 0.05) -> ActionOutcome:
    place = tuple(rng.normal([0.5, 0.0, 0.0], spread).tolist())
    return ActionOutcome("touch", rewarded=True, features={"place": place})


def explored(
    exploration: Exploration, actions: int, rewarding: Mapping[str, float], seed: int = 0
) -> list[str]:
    """Run an exploration of a world where some actions are always rewarded; what was chosen."""
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


def test_a_reward_is_the_change_relative_to_the_largest_until_then_minus_the_cost() -> None:
    rng, exploration = np.random.default_rng(5), catalog()
    steps = [exploration.note(touched(rng)) for _ in range(12)]
    assert steps[0].reward == pytest.approx(1 - 0.05)
    for index, step in enumerate(steps):
        largest = max(each.change for each in steps[: index + 1])
        assert step.reward == pytest.approx(step.change / largest - 0.05)


def test_failure_costs_and_noop_does_not() -> None:
    exploration = catalog(cost=0.2)
    assert exploration.note(ActionOutcome("lift")).reward == -0.2
    assert exploration.note(ActionOutcome(NOOP)).reward == 0.0
    assert exploration.affordances["lift"].tried == 1


@pytest.mark.parametrize("seed", range(5))
def test_what_is_known_is_left_for_doing_nothing(seed: int) -> None:
    exploration = catalog()
    chosen = explored(exploration, 120, {"touch": 0.05}, seed)
    assert chosen[-30:].count(NOOP) > chosen[:30].count(NOOP)
    assert (exploration.change_of("touch") or 0.0) < 0.25


def test_an_exploration_is_not_over_before_each_action_was_tried() -> None:
    rng, exploration = np.random.default_rng(5), catalog(least=2)
    for _ in range(30):
        exploration.note(touched(rng, 0.001))
    assert not exploration.is_over
    for _ in range(2):
        exploration.note(ActionOutcome("lift"))
    assert exploration.is_over


def test_an_action_that_joins_is_attended_to() -> None:
    exploration, both = catalog(), {"touch": 0.05, "inspect": 0.05}
    explored(exploration, 100, both)
    exploration.add({"inspect": PLACE})
    later = explored(exploration, 20, both, seed=1)
    assert later.count("inspect") >= 5


def test_what_cannot_be_run_is_left_out() -> None:
    exploration = catalog()
    exploration.note(ActionOutcome("lift", failed=True, ending="no hand"))
    assert "lift" not in explored(exploration, 50, {"touch": 0.05})


def test_an_action_whose_features_were_undefined_counts_and_teaches_nothing() -> None:
    rng, exploration = np.random.default_rng(5), catalog()
    exploration.note(touched(rng))
    before = exploration.affordances["touch"].model
    step = exploration.note(ActionOutcome("touch", rewarded=True))
    after = exploration.affordances["touch"].model
    assert before is not None and after is not None
    assert (step.change, after.variance(), after.tried) == (0.0, before.variance(), 2)


def models(**constants: float) -> ModelExploration:
    return ModelExploration(ACTIONS, ModelConstants(**constants))


def test_states_are_of_models() -> None:
    rng, exploration = np.random.default_rng(5), models()
    assert exploration.state == "XX"
    exploration.note(touched(rng)._replace(ahead=SEEN))
    assert exploration.state == "0X"
    exploration.note(ActionOutcome("lift", ahead=SEEN))
    assert exploration.state == "00"
    for _ in range(20):
        exploration.note(touched(rng, 0.01)._replace(ahead=SEEN))
    assert exploration.state == "10"
    exploration.note(ActionOutcome(NOOP, ahead={"touch": SEEN["touch"]}))
    assert exploration.state == "1-"


def test_what_was_moved_is_surprising() -> None:
    rng, exploration = np.random.default_rng(5), models()
    for _ in range(20):
        exploration.note(touched(rng, 0.01)._replace(ahead=SEEN))
    assert exploration.state[0] == "1"
    moved: dict[str, Mapping[str, tuple[float, ...]]] = {
        "touch": {"seen": (), "place": (0.5, 0.25, 0.0)}
    }
    exploration.note(ActionOutcome(NOOP, ahead=moved))
    assert exploration.state[0] == "0"


def test_q_values_are_those_of_the_update() -> None:
    rng, exploration = np.random.default_rng(5), models(promise=0.0, alpha=0.5, gamma=0.5)
    first = exploration.note(touched(rng)._replace(ahead=SEEN))
    assert exploration.table["XX"]["touch"] == pytest.approx(0.5 * first.reward)
    second = exploration.note(ActionOutcome("lift", ahead=SEEN))
    assert exploration.table["0X"]["lift"] == pytest.approx(0.5 * second.reward)


@pytest.mark.parametrize("seed", range(3))
def test_a_model_program_habituates(seed: int) -> None:
    chosen = explored(models(), 100, {"touch": 0.05, "lift": 0.05}, seed)
    assert chosen[-30:].count(NOOP) >= 20 > chosen[:15].count(NOOP)


def test_outcomes_before_a_model_began_are_in_it() -> None:
    """One was rewarded, though what its model is over was not defined then."""
    touch = catalog().affordances["touch"]
    constants = CatalogConstants()
    touch.note(ActionOutcome("touch", rewarded=True), constants)
    touch.note(ActionOutcome("touch", features={"place": (0.9, 0.0, 0.0)}), constants)
    touch.note(touched(np.random.default_rng(1)), constants)
    model = touch.model
    assert model is not None
    assert (model.tried, model.successes) == (3, 2) == (touch.tried, touch.successes)
    assert (model.rewarded.weight, model.unrewarded.weight) == (1.0, 1.0)
