"""Behavior trees: a policy as XML of BehaviorTree.CPP, version 4."""

from __future__ import annotations

from collections.abc import Iterator
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from cbdsl.errors.errors import UsageError
from cbdsl.program.checked import CheckedProgram
from cbdsl.types.state import closest_first, overlap

#: The leaves that whoever runs the tree brings, with their ports.
LEAVES = {
    "Rewarded": ("Condition", {"program": "That has earned its reward."}),
    "StateMatches": (
        "Condition",
        {
            "program": "Whose state.",
            "pattern": "That it has; * is any letter.",
            "unless": "Closer patterns, parted by ';', of which it has none.",
        },
    ),
    "RunAction": ("Action", {"program": "Whose action.", "action": "Composition to run."}),
}


def behavior_tree(program: CheckedProgram) -> str:
    """A program's policy, and those of the programs that it uses, as trees.

    Each pattern of a policy is a sequence of a condition on the state and an action. ``RunAction``
    is RUNNING until the state has changed, then SUCCESS, and FAILURE where its time ran out before.
    A tree succeeds with the reward, and fails where an action changed nothing or a state has none.

    Raises:
        UsageError: what is done follows from more than the state, as with a schema.
    """
    root = Element("root", BTCPP_format="4", main_tree_to_execute=program.name)
    for each in _with_used(program, set()):
        root.append(_tree(each))
    model = SubElement(root, "TreeNodesModel")
    for name, (kind, ports) in LEAVES.items():
        leaf = SubElement(model, kind, ID=name)
        for port, meaning in ports.items():
            SubElement(leaf, "input_port", name=port, type="std::string").text = meaning
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"


def _with_used(program: CheckedProgram, seen: set[str]) -> Iterator[CheckedProgram]:
    """A program and those that it uses, each once."""
    if program.schema is not None:
        raise UsageError(
            f"{program.name} is allocated by a schema, whose choice follows from where things are; "
            "a tree has only the state"
        )
    if program.name in seen:
        return
    seen.add(program.name)
    yield program
    for action in program.actions:
        if action.program is not None:
            yield from _with_used(action.program, seen)


def _tree(program: CheckedProgram) -> Element:
    tree = Element("BehaviorTree", ID=program.name)
    goal = SubElement(tree, "ReactiveFallback", name=program.name)
    SubElement(goal, "Rewarded", program=program.name)
    again = SubElement(goal, "KeepRunningUntilFailure")
    choice = SubElement(again, "Fallback", name=f"policy of {program.name}")
    used = {action.name: action.program for action in program.actions if action.program}
    patterns = list(closest_first(program.policy))
    for place, pattern in enumerate(patterns):
        action = program.policy[pattern]
        closer = [each for each in patterns[:place] if overlap(each, pattern)]
        branch = SubElement(choice, "Sequence", name=f"{pattern}: {action}")
        SubElement(
            branch, "StateMatches", program=program.name, pattern=pattern, unless=";".join(closer)
        )
        if action in used:
            # How it ended is a letter of the state, by which the policy goes on.
            SubElement(SubElement(branch, "ForceSuccess"), "SubTree", ID=used[action].name)
        else:
            SubElement(branch, "RunAction", program=program.name, action=action)
    return tree
