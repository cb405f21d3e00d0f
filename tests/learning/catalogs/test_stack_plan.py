"""Plans of stacks, and which pair comes next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import networkx as nx
import numpy as np
import pytest

from cbdsl.documents.meta_catalog import MetaCatalogDocument, PairSection, Relation
from cbdsl.learning.catalogs.action_outcome import ActionOutcome, FeatureForm
from cbdsl.learning.catalogs.catalog_exploration import CatalogConstants
from cbdsl.learning.catalogs.stack_plan import pairs_of, plan_stack, plan_stacks
from cbdsl.learning.catalogs.thing_graph import support_graph, thing_graph
from cbdsl.training.exploration.pair_task import PairExploration


def support(pairs: Mapping[tuple[str, str], float]) -> Any:
    """Return a graph of the probabilities that the second of two objects stands on the first."""
    graph: Any = nx.DiGraph()
    graph.add_edges_from((*pair, {"probability": own}) for pair, own in pairs.items())
    return graph


SUPPORT = support({("slab", "box"): 0.9, ("slab", "ball"): 0.95, ("box", "ball"): 0.8})


def test_surest_path_is_planned_from_below() -> None:
    plan = plan_stack(SUPPORT, 3)
    assert plan.order == ("slab", "box", "ball")
    assert plan.probability == pytest.approx(0.72)
    assert plan_stack(SUPPORT, 2).order == ("slab", "ball")


def test_plan_uses_only_pairs_that_stood_and_refuses_unknown_objects() -> None:
    assert [plan.order for plan in plan_stacks(SUPPORT, 3)] == [("slab", "box", "ball")]
    assert not plan_stacks(SUPPORT, 4)


def test_plan_contains_no_object_twice() -> None:
    assert not plan_stacks(support({("a", "b"): 0.9, ("b", "a"): 0.9}), 3)


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


def test_exploration_of_pairs_prefers_changing_models_and_drops_unstable_pairs() -> None:
    exploration = explored({"a_on_b": [True, True], "b_on_a": [False] * 4})
    chosen = [exploration.choose(np.random.default_rng(seed)) for seed in range(40)]
    assert chosen.count("a_on_b") > 30
    assert chosen.count("b_on_a") < 4


def catalog() -> MetaCatalogDocument:
    def pair(
        upper: str, lower: str, tried: int, rewarded: int, relation: Relation = "on"
    ) -> PairSection:
        counts = {"program": "stand", "tried": tried, "rewarded": rewarded}
        given = {"upper": upper, "lower": lower, "relation": relation, **counts}
        return PairSection.model_validate(given)

    things = {"slab": {"feature": "blue", "catalog": "slabs"}, "box": {"feature": "red"}}
    things |= {"ball": {"feature": "green"}, "cup": {"feature": "hue_9"}}
    return MetaCatalogDocument.model_validate(
        {"cbdsl": 1, "kind": "meta_catalog", "name": "some", "robot": "dexter", "things": things}
    ).model_copy(
        update={
            "pairs": {
                "a": pair("box", "slab", 6, 4),
                "b": pair("ball", "slab", 5, 0),
                "c": pair("ball", "cup", 3, 3, relation="in"),
                "d": pair("cup", "box", 2, 2),
                "e": pair("ball", "cup", 4, 3),
            }
        }
    )


def test_graph_holds_objects_pairs_and_provenance() -> None:
    graph = thing_graph(catalog())
    assert graph.graph == {"name": "some", "robot": "dexter"}
    assert graph.nodes["slab"] == {"feature": "blue", "catalog": "slabs"}
    assert set(graph["cup"]["ball"]) == {"in", "on"}
    facts = {"pair": "a", "tried": 6, "rewarded": 4, "probability": 5 / 8}
    assert graph["slab"]["box"]["on"] == facts
    assert graph["slab"]["ball"]["on"]["probability"] == 0.0


def test_support_probability_follows_laplace_s_rule() -> None:
    known = support_graph(catalog())
    own = {(low, high): facts["probability"] for low, high, facts in known.edges(data=True)}
    assert own == {("slab", "box"): 5 / 8, ("box", "cup"): 3 / 4, ("cup", "ball"): 4 / 6}
    plan = plan_stack(known, 4)
    assert plan.order == ("slab", "box", "cup", "ball")
    assert pairs_of(known, plan.order) == ["a", "d", "e"], "not c, which was in it"
    assert set(support_graph(catalog(), ["cup", "ball"]).edges) == {("cup", "ball")}


def test_stack_that_cannot_be_is_refused_with_all_that_is_there() -> None:
    with pytest.raises(ValueError, match=r"no stack of 4 is known of ball, box, slab$"):
        plan_stack(SUPPORT, 4)
    with pytest.raises(ValueError, match=r"no stack of 2 is known of nothing$"):
        plan_stack(support({}), 2)
    with pytest.raises(ValueError, match=r"no stack of 2 is known of ball, slab$"):
        plan_stack(support_graph(catalog(), ["ball", "slab"]), 2)


def test_equally_probable_stacks_are_ordered_by_name() -> None:
    plans = plan_stacks(support({("c", "b"): 0.5, ("c", "a"): 0.5, ("c", "d"): 0.6}), 2)
    assert [plan.order for plan in plans] == [("c", "d"), ("c", "a"), ("c", "b")]


def test_as_many_trials_as_asked_for_are_enough() -> None:
    """Let the bandit choose after these trials; it drops options without reward."""
    exploration = explored({"a_on_b": [True, True], "b_on_a": [False, False]})
    chosen = [exploration.choose(np.random.default_rng(seed)) for seed in range(20)]
    assert chosen.count("a_on_b") > 15
