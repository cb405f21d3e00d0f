"""Behavior trees: read as BehaviorTree.CPP reads them, they choose the policy's actions."""

from __future__ import annotations

from itertools import product
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import pytest

from cbdsl.diagnostics.errors import UsageError
from cbdsl.runtime.policies.policy import WrittenPolicy
from cbdsl.types.state import matches
from cbdsl_trees.behavior_tree import LEAVES, behavior_tree
from tests.conftest import Checked


def holds(condition: Element, state: str) -> bool:
    """Return True if a condition on the state, or one of several, holds."""
    if condition.tag == "ReactiveFallback":
        return any(holds(each, state) for each in condition)
    unless = [each for each in condition.get("unless", "").split(";") if each]
    pattern = condition.get("pattern", "")
    return matches(pattern, state) and not any(matches(each, state) for each in unless)


def chosen(policy: Element, state: str) -> list[str]:
    """Return the actions of all branches whose condition holds; a fallback takes the first."""
    branches = [each for each in policy if each.tag == "ReactiveSequence"]
    return [branch.get("name", "") for branch in branches if holds(branch[0], state)]


@pytest.mark.parametrize("name", ["searchtrack", "reachtouch", "pick_and_lift", "visualinspect"])
def test_every_state_has_the_policys_action_and_no_other(checked: Checked, name: str) -> None:
    program = checked(name)
    root = ElementTree.fromstring(behavior_tree(program))
    assert root.get("BTCPP_format") == "4" and root.get("main_tree_to_execute") == name
    (tree,) = root.findall(f"BehaviorTree[@ID='{name}']")
    place = "actions" if program.episode_time is not None else f"policy of {name}"
    (choice,) = tree.findall(f".//ReactiveFallback[@name='{place}']")
    policy = WrittenPolicy(program.policy)
    for letters in product("X-01", repeat=len(program.members)):
        state = "".join(letters)
        action = policy.choose(state, changed=True).action
        assert chosen(choice, state) == ([] if action is None else [action]), state


def test_every_use_of_a_program_is_a_tree_of_its_own(checked: Checked) -> None:
    root = ElementTree.fromstring(behavior_tree(checked("visualinspect")))
    trees = [tree.get("ID") for tree in root.findall("BehaviorTree")]
    assert trees[0] == "visualinspect" and len(trees) > 1
    assert len(set(trees)) == len(trees)
    used = [each.get("ID") for each in root.iter("SubTree")]
    assert sorted(str(each) for each in used) == sorted(str(each) for each in trees[1:])


def test_tree_declares_all_leaves_with_their_ports(checked: Checked) -> None:
    root = ElementTree.fromstring(behavior_tree(checked("visualinspect")))
    model = root.find("TreeNodesModel")
    assert model is not None and {each.get("ID") for each in model} == set(LEAVES)
    ports = {each.get("ID"): {port.get("name") for port in each} for each in model}
    builtin = {"Fallback", "ReactiveFallback", "Sequence", "ReactiveSequence", "Inverter"}
    builtin |= {"KeepRunningUntilFailure", "SubTree", "BehaviorTree"}
    for tree in root.findall("BehaviorTree"):
        for node in tree.iter():
            if node.tag not in builtin:
                assert set(node.attrib) - {"name"} == ports[node.tag]
        # BehaviorTree.CPP forbids these in an ID.
        assert not set(str(tree.get("ID"))) & set(" <>&\"'/\\:*?|.")


def test_conditions_of_a_tree_have_names_in_words(checked: Checked) -> None:
    root = ElementTree.fromstring(behavior_tree(checked("pick_and_lift")))
    conditions = list(root.iter("StateMatches"))
    assert all(each.get("name") for each in conditions)
    names = {each.get("pattern"): each.get("name") for each in conditions}
    (tree,) = root.findall("BehaviorTree[@ID='pick_and_lift']")
    (ending,) = [each for each in tree[0] if each.tag == "StateMatches"]
    assert str(ending.get("name")).startswith("succeed, since ")
    assert any(" is undefined" in str(each) for each in names.values())


def test_parameters_and_outcomes_are_in_the_tree(checked: Checked) -> None:
    program = checked("searchtrack", feature="hue_4")._replace(
        success=("*1",), failure=("-*",), episode_time=3.5, reward_ends=False
    )
    root = ElementTree.fromstring(behavior_tree(program))
    leaves = [each for each in root.iter() if each.tag in LEAVES]
    assert leaves and {each.get("with") for each in leaves} == {"feature=hue_4"}
    (tree,) = root.findall("BehaviorTree")
    assert tree[0][0].get("pattern") == "*1"
    (inverter,) = tree.findall(".//Inverter")
    assert inverter[0].get("pattern") == "-*"
    limits = {(each.get("transitions"), each.get("seconds")) for each in root.iter("WithinLimits")}
    assert limits == {(str(program.transitions), ""), ("", "3.5")}


def test_program_with_a_schema_has_no_tree(checked: Checked) -> None:
    program = checked("reachtouch")
    with pytest.raises(UsageError, match="allocated by a schema"):
        behavior_tree(program._replace(schema=object()))
