"""Behavior trees: read as BehaviorTree.CPP reads them, they choose what the policy chooses."""

from __future__ import annotations

from itertools import product
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import pytest

from cbdsl.errors.errors import UsageError
from cbdsl.program.behavior_tree import LEAVES, behavior_tree
from cbdsl.types.policy import WrittenPolicy
from cbdsl.types.state import matches
from tests.conftest import Checked


def chosen(choice: Element, state: str) -> list[str]:
    """The actions of all branches whose condition holds; a fallback takes the first."""
    actions = []
    for branch in choice:
        condition, action = branch
        unless = [each for each in condition.get("unless", "").split(";") if each]
        if matches(condition.get("pattern"), state) and not any(matches(p, state) for p in unless):
            leaf = action[0] if action.tag == "ForceSuccess" else action
            actions.append(leaf.get("action") or leaf.get("ID"))
    return actions


@pytest.mark.parametrize("name", ["searchtrack", "reachtouch", "pick_and_lift", "visualinspect"])
def test_every_state_has_the_policys_action_and_no_other(checked: Checked, name: str) -> None:
    program = checked(name)
    root = ElementTree.fromstring(behavior_tree(program))
    assert root.get("BTCPP_format") == "4" and root.get("main_tree_to_execute") == name
    (tree,) = root.findall(f"BehaviorTree[@ID='{name}']")
    goal = tree[0]
    assert [each.tag for each in goal] == ["Rewarded", "KeepRunningUntilFailure"]
    policy = WrittenPolicy(program.policy)
    for letters in product("X-01", repeat=len(program.members)):
        state = "".join(letters)
        action = policy.choose(state, changed=True)
        assert chosen(goal[1][0], state) == ([] if action is None else [action]), state


def test_used_programs_are_trees_and_all_leaves_are_declared(checked: Checked) -> None:
    root = ElementTree.fromstring(behavior_tree(checked("visualinspect")))
    trees = {tree.get("ID") for tree in root.findall("BehaviorTree")}
    assert {"visualinspect", "reachtouch", "searchtrack"} <= trees
    assert {each.get("ID") for each in root.iter("SubTree")} <= trees
    model = root.find("TreeNodesModel")
    assert model is not None and {each.get("ID") for each in model} == set(LEAVES)
    builtin = {"Fallback", "ReactiveFallback", "Sequence", "KeepRunningUntilFailure"}
    builtin |= {"ForceSuccess", "SubTree"}
    used = {each.tag for tree in root.findall("BehaviorTree") for each in tree.iter()}
    assert used - builtin - {"BehaviorTree"} <= set(LEAVES)


def test_what_follows_from_more_than_the_state_is_refused(checked: Checked) -> None:
    program = checked("reachtouch")
    with pytest.raises(UsageError, match="allocated by a schema"):
        behavior_tree(program._replace(schema=object()))
