"""Values of states by the transitions that were observed."""

from __future__ import annotations

import pytest

from cbdsl.documents.policy import PolicyDocument
from cbdsl.program.state_values import state_values
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

COUNTS = {
    "XX": {"look": {"0-": 3, "1-": 1}},
    "0-": {"look": {"11": 2}, "wait": {"0-": 9}},
    "1-": {"look": {"XX": 1}},
}


def test_final_state_has_value_1_and_earlier_states_are_discounted() -> None:
    values = state_values({"**": "look"}, COUNTS)
    assert values["11"] == 1.0
    assert values["0-"] == pytest.approx(0.8)
    assert values["XX"] == pytest.approx(0.8 * (0.75 * 0.8 + 0.25 * values["1-"]))
    assert values["1-"] == pytest.approx(0.8 * values["XX"])


def test_only_actions_of_the_policy_count() -> None:
    assert state_values({"0-": "wait", "**": "look"}, COUNTS)["0-"] == 0.0


def test_shipped_policy_knows_the_route_to_its_reward() -> None:
    library = Library(ROOT)
    path = library.locate(PolicyDocument, "reachtouch")
    policy = library.read(path, PolicyDocument).document
    learned_values = state_values(policy.policy, policy.transitions)
    route = ["XXX", "X0-", "X00", "X10", "X11"]
    along = [learned_values[state] for state in route]
    assert along == sorted(along) and along[0] > 0.0
    beside = learned_values.keys() - set(route)
    assert beside and max(learned_values[state] for state in beside) < learned_values["X0-"]
