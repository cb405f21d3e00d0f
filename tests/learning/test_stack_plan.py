"""Plans of stacks, and which pair comes next."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.documents.meta_catalog import MetaCatalogDocument, PairSection, Relation
from cbdsl.learning.action_outcome import ActionOutcome, FeatureForm
from cbdsl.learning.catalog_exploration import CatalogConstants
from cbdsl.learning.pair_exploration import PairExploration
from cbdsl.learning.pair_recognition import recognise
from cbdsl.learning.stack_plan import plan_stack, plan_stacks, support_of
from cbdsl.numeric.affordance import AffordanceModel

SUPPORT = {
    ("box", "slab"): 0.9,
    ("ball", "slab"): 0.95,
    ("ball", "box"): 0.8,
    ("box", "ball"): 0.0,
    ("slab", "box"): 0.0,
}


def test_the_surest_path_is_planned_from_below() -> None:
    plan = plan_stack(SUPPORT, 3)
    assert plan.order == ("slab", "box", "ball")
    assert plan.probability == pytest.approx(0.72)
    assert plan_stack(SUPPORT, 2).order == ("slab", "ball")


def test_only_what_is_there_is_stacked() -> None:
    assert plan_stack(SUPPORT, 2, ["box", "ball"]).order == ("box", "ball")
    with pytest.raises(ValueError, match="no stack of 3 is known of ball, box"):
        plan_stack(SUPPORT, 3, ["box", "ball"])


def test_what_never_stood_is_in_no_plan() -> None:
    assert [plan.order for plan in plan_stacks(SUPPORT, 3)] == [("slab", "box", "ball")]
    assert not plan_stacks(SUPPORT, 4)


def test_nothing_stands_on_itself_in_a_circle() -> None:
    around = {("a", "b"): 0.9, ("b", "a"): 0.9}
    assert not plan_stacks(around, 3)


def explored(outcomes: dict[str, list[bool]], least: int = 2) -> PairExploration:
    forms = (FeatureForm("offset", "m", 3),)
    exploration = PairExploration(
        dict.fromkeys(outcomes, forms), CatalogConstants(least=least, temperature=0.02)
    )
    for name, rewarded in outcomes.items():
        for number, each in enumerate(rewarded):
            seen = {"offset": (0.0, 0.01 * number, 0.1)}
            exploration.note(ActionOutcome(name, each, seen if each else {}))
    return exploration


def test_pairs_that_were_hardly_tried_come_first() -> None:
    exploration = explored({"a_on_b": [True, True], "b_on_a": [False], "c_on_a": [False]})
    chosen = {exploration.choose(np.random.default_rng(seed)) for seed in range(20)}
    assert chosen == {"b_on_a", "c_on_a"}


def test_then_what_tells_most_is_taken_and_what_never_stays_is_left() -> None:
    exploration = explored({"a_on_b": [True, True], "b_on_a": [False] * 4})
    chosen = [exploration.choose(np.random.default_rng(seed)) for seed in range(40)]
    assert chosen.count("a_on_b") > 30
    assert chosen.count("b_on_a") < 4


def test_two_things_look_like_a_known_pair_or_like_none() -> None:
    models = {}
    for name, height in (("low", 0.05), ("high", 0.2)):
        model = AffordanceModel.fresh(np.full(3, 0.03))
        for shift in (-0.01, 0.0, 0.01, 0.005):
            model = model.updated(np.array([shift, -shift, height + shift]), rewarded=True)
        models[name] = model
    assert recognise(models, np.array([0.0, 0.0, 0.06])).pair == "low"
    assert recognise(models, np.array([0.0, 0.0, 0.19])).pair == "high"
    beside = recognise(models, np.array([0.2, 0.1, 0.0]))
    assert beside.pair is None and beside.distance > 4
    assert recognise({}, np.zeros(3)).pair is None
    assert recognise({n: m.over([2]) for n, m in models.items()}, np.array([0.19])).pair == "high"


def test_likeness_ends_where_one_in_a_thousand_of_its_own_would_not_be_like_it() -> None:
    """Fisher's chi-squared law of squared distances: 10.828 for one component, 16.266 for three."""
    for size, bound in ((1, 10.828**0.5), (3, 16.266**0.5)):
        model = AffordanceModel.fresh(np.full(size, 0.03)).updated(np.zeros(size), rewarded=True)
        away = np.eye(size)[0] * 0.03
        unit = away / model.distance(away)
        for share, pair in ((0.999, "pair"), (1.001, None)):
            likeness = recognise({"pair": model}, share * bound * unit)
            assert likeness == (pair, pytest.approx(share * bound))


def test_a_pair_that_never_stayed_is_not_recognised() -> None:
    never = AffordanceModel.fresh(np.ones(1)).updated(np.zeros(1), rewarded=False)
    assert recognise({"never": never}, np.zeros(1)) == (None, np.inf)


def test_support_is_by_laplace_s_rule_and_of_what_stood_upon() -> None:
    def pair(upper: str, tried: int, rewarded: int, relation: Relation = "on") -> PairSection:
        counts = {"program": "stand", "tried": tried, "rewarded": rewarded}
        given = {"upper": upper, "lower": "slab", "relation": relation, **counts}
        return PairSection.model_validate(given)

    pairs = {
        "a": pair("box", 6, 4), "b": pair("ball", 5, 0), "c": pair("cup", 3, 3, relation="in")
    }  # fmt: skip
    catalog = MetaCatalogDocument.model_construct(pairs=pairs)
    assert support_of(catalog) == {("box", "slab"): 5 / 8, ("ball", "slab"): 0.0}


def test_a_stack_that_cannot_be_is_refused_with_all_that_is_known() -> None:
    with pytest.raises(ValueError, match=r"no stack of 4 is known of ball, box, slab$"):
        plan_stack(SUPPORT, 4)
    with pytest.raises(ValueError, match=r"no stack of 2 is known of nothing$"):
        plan_stack({}, 2)


def test_of_equally_sure_stacks_the_first_by_name_is_planned() -> None:
    plans = plan_stacks({("b", "c"): 0.5, ("a", "c"): 0.5, ("d", "c"): 0.6}, 2)
    assert [plan.order for plan in plans] == [("c", "d"), ("c", "a"), ("c", "b")]


def test_as_many_trials_as_asked_for_are_enough() -> None:
    """From then on the bandit chooses, which leaves what earned nothing."""
    exploration = explored({"a_on_b": [True, True], "b_on_a": [False, False]})
    chosen = [exploration.choose(np.random.default_rng(seed)) for seed in range(20)]
    assert chosen.count("a_on_b") > 15
