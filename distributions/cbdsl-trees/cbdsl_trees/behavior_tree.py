"""Behavior trees: a policy as XML of BehaviorTree.CPP, version 4.

A tree is ticked at the control rate. It is reactive: each tick judges all conditions again. Their
order is that of a program: success, failure, reward, transitions, time, policy. The patterns of one
action are one branch, so that the action goes on while the state changes among them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from cbdsl.api.program import ANY, Action, CheckedProgram, Predicate, closest_first, overlap
from cbdsl.extend.command import UsageError
from cbdsl.extend.export import member_kinds, state_text

_RUN = {
    "run": "Name of one use of a program: the tree's ID.",
    "program": "Name of the program.",
    "with": "Values of the program's parameters, as NAME=VALUE, parted by ';'.",
}
#: The leaves that the user of a tree implements, with their ports.
LEAVES: Mapping[str, tuple[str, Mapping[str, str]]] = {
    "Rewarded": ("Condition", {**_RUN}),
    "StateMatches": (
        "Condition",
        {
            **_RUN,
            "pattern": "Pattern of the state; * is any letter; a is 1 on arrival, s 1 if stuck.",
            "unless": "Patterns that the state must not have, parted by ';'.",
        },
    ),
    "WithinLimits": (
        "Condition",
        {
            **_RUN,
            "transitions": "Number of changes of state that the run may have; empty for any.",
            "seconds": "Time that the run may last, s; empty for any.",
        },
    ),
    "SetPredicate": (
        "Action",
        {
            **_RUN,
            "member": "Used program of which the predicate is set; those of all others become X.",
            "predicate": "0 as it begins, 1 after its success, - after its failure.",
        },
    ),
    "RunAction": (
        "Action",
        {
            **_RUN,
            "action": "Composition to run.",
            "seconds": "Time after which an action fails that has not changed the state, s.",
            "idle": "The same while no member of the state is 0, s; empty for no limit.",
        },
    ),
}


class _Use(NamedTuple):
    """One use of a program.

    Attributes:
        path: Actions that lead to it, from the main program on.
        program: The program, with the values of its parameters.
    """

    path: tuple[str, ...]
    program: CheckedProgram

    @property
    def name(self) -> str:
        """ID of its tree; a name of a program or an action has no hyphen."""
        return "-".join(self.path)

    def used(self, action: Action) -> _Use | None:
        """Return the use of the program that an action is, or ``None`` for a composition."""
        if action.program is None or action.composition is not None:
            return None
        # A member with arguments has signs that are forbidden in an ID.
        place = self.program.actions.index(action)
        name = re.sub(r"\W", "_", action.name)
        return _Use(
            (*self.path, name if name == action.name else f"{name}_{place}"), action.program
        )


def behavior_tree(program: CheckedProgram) -> str:
    """Return a program's policy, and those of the programs that it uses, as trees.

    Each use of a program is a tree of its own, which succeeds and fails if the program does. The
    state of a run has one letter per member of its program. ``SetPredicate`` sets that of a used
    program, and always succeeds. ``RunAction`` runs a composition, gives the letters of its
    controllers, and is RUNNING until it is halted; all other letters become X. It is FAILURE if the
    state did not change within its time.

    Raises:
        UsageError: The next action follows from more than the state, as with a schema.
    """
    main = _Use((program.name,), program)
    root = Element("root", BTCPP_format="4", main_tree_to_execute=main.name)
    for use in _uses(main):
        root.append(_tree(use))
    model = SubElement(root, "TreeNodesModel")
    for name, (kind, ports) in LEAVES.items():
        leaf = SubElement(model, kind, ID=name)
        for port, meaning in ports.items():
            SubElement(leaf, "input_port", name=port, type="std::string").text = meaning
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"


def _uses(use: _Use) -> Iterator[_Use]:
    """Yield a use of a program, and the uses of programs in it."""
    if use.program.schema is not None:
        raise UsageError(
            f"{use.program.name} is allocated by a schema, whose choice follows from where things "
            "are; a tree has only the state"
        )
    yield use
    for action in use.program.actions:
        inner = use.used(action)
        if inner is not None:
            yield from _uses(inner)


def _tree(use: _Use) -> Element:
    """Return the tree of one use of a program."""
    # Nodes of a tree in the order of its conditions, and their results:
    #     ReactiveFallback         SUCCESS at the first pattern of success
    #         ReactiveSequence     FAILURE at the first pattern of failure, by an Inverter
    #             Rewarded         SUCCESS at a reward, only if a reward ends the program
    #             WithinLimits     FAILURE after too many transitions
    #             policy           RUNNING with an action, FAILURE in a state without one
    program = use.program
    tree = Element("BehaviorTree", ID=use.name)
    outcome = SubElement(tree, "ReactiveFallback", name=program.name)
    for pattern in program.success:
        _state(outcome, use, pattern, _initial(program, pattern), "succeed")
    going_on = SubElement(outcome, "ReactiveSequence", name="without success")
    for pattern in program.failure:
        to = f"fail {program.reasons.get(pattern, '')}".rstrip()
        inverter = SubElement(going_on, "Inverter", name=f"unless {to}")
        _state(inverter, use, pattern, _initial(program, pattern), to)
    if program.reward_ends and _is_rewardable(program):
        going_on = SubElement(going_on, "ReactiveFallback", name="reward or policy")
        _leaf(going_on, "Rewarded", use)
        going_on = SubElement(going_on, "ReactiveSequence", name="policy within limits")
    _leaf(going_on, "WithinLimits", use, transitions=str(program.transitions), seconds="")
    _add_policy(SubElement(going_on, "ReactiveFallback", name=f"policy of {program.name}"), use)
    return tree


def _add_policy(policy: Element, use: _Use) -> None:
    """Add the branches of a policy, and the conditions of success after its end."""
    program, parent = use.program, policy
    if program.episode_time is not None:
        parent = SubElement(policy, "ReactiveSequence", name="within time")
        _leaf(parent, "WithinLimits", use, transitions="", seconds=f"{program.episode_time:g}")
        parent = SubElement(parent, "ReactiveFallback", name="actions")
    patterns = list(closest_first(program.policy))
    for action in program.actions:
        own = [pattern for pattern in patterns if program.policy[pattern] == action.name]
        if own:
            _add_branch(parent, use, action, own)
    if not program.reward_ends and _is_rewardable(program):
        _leaf(policy, "Rewarded", use)
    if not _has_rewarded_controllers(program):
        # Without possible reward, a program succeeds at rest if it has no further action.
        for place in range(len(program.members)):
            rest = ANY * place + Predicate.QUIESCENT + ANY * (len(program.members) - place - 1)
            _state(policy, use, rest, patterns, "succeed")


def _add_branch(policy: Element, use: _Use, action: Action, own: list[str]) -> None:
    """Add the branch of an action: a condition on the state, and the action.

    Args:
        policy: Parent of the branch.
        use: Use of the program.
        action: The action.
        own: Patterns of the states in which the policy selects it.
    """
    patterns = list(closest_first(use.program.policy))
    branch = SubElement(policy, "ReactiveSequence", name=action.name)
    words = " or ".join(_words(use.program, pattern) for pattern in own)
    any_of = SubElement(branch, "ReactiveFallback", name=words) if own[1:] else branch
    for pattern in own:
        # The closest pattern applies. A state that also matches a closer one belongs to that
        # pattern's branch, and is excluded here.
        before = patterns[: patterns.index(pattern)]
        closer = [each for each in before if overlap(each, pattern)]
        _state(any_of, use, pattern, closer, use.program.steps.get(action.name, action.name))
    inner = use.used(action)
    if inner is None:
        idle = use.program.idle_time
        _leaf(
            branch,
            "RunAction",
            use,
            action=action.name,
            seconds=f"{use.program.transition_time:g}",
            idle="" if idle is None else f"{idle:g}",
        )
        return
    # The end of a used program is a letter of the state, which the policy continues from.
    again = SubElement(branch, "KeepRunningUntilFailure", name=f"run {action.name}")
    end = SubElement(again, "Fallback", name=f"end of {action.name}")
    success = SubElement(end, "Sequence", name=f"success of {action.name}")
    _leaf(success, "SetPredicate", use, member=action.name, predicate=Predicate.TRANSIENT)
    SubElement(success, "SubTree", ID=inner.name)
    _leaf(success, "SetPredicate", use, member=action.name, predicate=Predicate.QUIESCENT)
    _leaf(end, "SetPredicate", use, member=action.name, predicate=Predicate.UNDEFINED)


def _initial(program: CheckedProgram, pattern: str) -> list[str]:
    """Return the state at the beginning if it has a pattern: no outcome follows from it."""
    # Without this exception, a pattern of wildcards alone would end its program before the first
    # action.
    state = Predicate.INACTIVE * len(program.members)
    return [state] if overlap(pattern, state) else []


def _is_rewardable(program: CheckedProgram) -> bool:
    """Return whether a member can be rewarded, be it a controller or a program in its place."""
    stood_for = (program.primitives.get(a.part) for a in program.actions if a.program is not None)
    return _has_rewarded_controllers(program) or any(
        p is not None and p.rewarded for p in stood_for
    )


def _has_rewarded_controllers(program: CheckedProgram) -> bool:
    compositions = (action.composition for action in program.actions)
    return any(each.rewarded for own in compositions if own for each in own.primitives)


def _words(program: CheckedProgram, pattern: str) -> str:
    """Return a pattern in words, such as ``lift is at rest``."""
    return state_text(program.members, pattern, member_kinds(program))


def _state(parent: Element, use: _Use, pattern: str, unless: list[str], to: str = "") -> None:
    words = _words(use.program, pattern)
    leaf = _leaf(parent, "StateMatches", use, pattern=pattern, unless=";".join(unless))
    # Editors of trees show this name; it is no port.
    leaf.set("name", f"{to}, since {words}" if to else words)


def _leaf(parent: Element, name: str, use: _Use, **ports: str) -> Element:
    values = ";".join(f"{key}={value}" for key, value in use.program.parameters.items())
    run = {"run": use.name, "program": use.program.name, "with": values}
    return SubElement(parent, name, {**run, **ports})
