"""Exported trees, executed by BehaviorTree.CPP: they end as the programs do."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

import cbdsl
from cbdsl_trees.behavior_tree import LEAVES, behavior_tree
from tests.conftest import ROOT

behaviortreepy = pytest.importorskip("behaviortreepy")
from behaviortreepy import NodeStatus  # noqa: E402
from tree_player import TreePlayer, with_ports_in_names  # noqa: E402

PROGRAMS = sorted((ROOT / "programs").glob("*.yaml"))
HEAD = "cbdsl: 1\nkind: program\nname: {name}\nrobot: dexter\nstage: absent\n"
TWO = """\
use:
  left: {program: posture, with: {arm: left_arm, posture: ready}}
  right: {program: posture, with: {arm: right_arm, posture: home}}
controllers: {}
actions: [left, right]
"""
TURN = """\
parameters: {goal: head.ahead}
controllers:
  turn: {potential: spring, reference: $goal, feedback: head, effector: head}
  arm: {potential: spring, reference: right_arm.home, feedback: right_arm, effector: right_arm}
actions: [turn, arm, turn ◁ arm, arm ◁ turn]
"""
MIXED = """\
use: {left: {program: posture, with: {arm: left_arm, posture: ready}}}
controllers:
  turn: {potential: spring, reference: head.ahead, feedback: head, effector: head}
actions: [turn, left]
"""


def outcomes(program: str, seed: int = 3) -> tuple[bool, bool, list[tuple[str, str]]]:
    """Return whether a program succeeds, whether its tree does, and the actions of the tree."""
    request = cbdsl.load(program)
    with cbdsl.open_robot(request, backend="kinematic") as robot:
        robot.run(seed)
        run = robot.runner().predicate == "1"
    with cbdsl.open_robot(request, backend="kinematic", persistent=True) as robot:
        player = TreePlayer(behavior_tree(request.program), robot, seed)
        tree = player.play() == NodeStatus.SUCCESS
    return run, tree, player.actions


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "programs").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(here: Path, name: str, text: str) -> str:
    (here / "programs" / f"{name}.yaml").write_text(HEAD.format(name=name) + text, "utf-8")
    return name


def test_two_uses_of_one_program_run_with_their_own_arguments(here: Path) -> None:
    policy = "policy: {XX: left, 0X: left, 1X: right, X0: right}\n"
    ends = 'success: [X1]\nfailure: ["-*"]\n'
    run, tree, actions = outcomes(write(here, "two", TWO + policy + ends))
    assert run and tree
    assert [run for run, _ in actions] == ["two-left", "two-right"]


CASES = {
    "success": (TWO, "policy: {XX: left, 0X: left}\nsuccess: [1*]\n", True),
    "failure": (TWO, 'policy: {XX: left, 0X: left, 1X: right}\nfailure: ["1*"]\n', False),
    "success_at_the_beginning": (TWO, 'policy: {XX: left}\nsuccess: ["X*"]\n', False),
    "at_rest": (TWO, "policy: {XX: right, X0: right}\n", True),
    "no_action": (TWO, "policy: {XX: right}\n", False),
    "used_up": (TWO, "policy: {XX: left, 0X: left, 1X: right}\nlimits: {transitions: 1}\n", False),
    "back_and_forth": (
        TWO, "policy: {'**': left, 1X: right}\nlimits: {transitions: 9}\n", False,
    ),
    "controllers": (TURN, "policy: {XX: turn, 0X: turn, 1X: turn ◁ arm, 10: turn ◁ arm}\n", True),
    "switched": (TURN, "policy: {XX: turn, 0X: arm, X0: arm, X1: turn ◁ arm}\n", True),
    "controllers_success": (TURN, "policy: {XX: turn, 0X: turn}\nsuccess: [0X]\n", True),
    "controllers_failure": (TURN, "policy: {XX: turn, 0X: turn}\nfailure: [0X]\n", False),
    "out_of_time": (
        TURN, "policy: {XX: turn, 0X: turn}\nlimits: {transition_time: 20 ms}\n", False,
    ),
    "mixed": (MIXED, "policy: {XX: turn, 0X: turn, 1X: left, X0: left}\nsuccess: [X1]\n", True),
    "mixed_reversed": (MIXED, "policy: {XX: left, X0: left, X1: turn, 0X: turn}\n", True),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_tree_ends_as_its_program_does(here: Path, case: str) -> None:
    members, policy, expected = CASES[case]
    run, tree, _ = outcomes(write(here, case, members + policy))
    assert (run, tree) == (expected, expected)


def test_tree_of_uses_within_uses_has_each_with_its_arguments(here: Path) -> None:
    policy = "policy: {X: part, '0': part}\n"
    part = "use: {part: {program: posture, with: {arm: $arm, posture: home}}}\n"
    write(
        here,
        "inner",
        f"parameters: {{arm: left_arm}}\n{part}controllers: {{}}\nactions: [part]\n" + policy,
    )
    uses = "use: {a: {program: inner}, b: {program: inner, with: {arm: right_arm}}}\n"
    text = uses + "controllers: {}\nactions: [a, b]\npolicy: {XX: a, 0X: a, 1X: b, X0: b}\n"
    run, tree, actions = outcomes(write(here, "outer", text + "success: [X1]\n"))
    assert run and tree
    assert [run for run, _ in actions] == ["outer-a-part", "outer-b-part"]


@pytest.mark.parametrize("seed", range(3))
def test_rewarded_program_ends_as_its_tree(seed: int) -> None:
    run, tree, actions = outcomes("searchtrack", seed)
    assert run and tree and actions


@pytest.mark.parametrize("seed", range(10))
def test_random_policy_ends_as_its_tree(here: Path, seed: int) -> None:
    rng = random.Random(seed)
    members, actions = rng.choice(
        [(TWO, ["left", "right"]), (TURN, ["turn", "arm", "turn ◁ arm"]), (MIXED, ["turn", "left"])]
    )
    patterns = rng.sample([a + b for a in "X01*" for b in "X01*"], 6)
    policy = {"XX": rng.choice(actions), **{each: rng.choice(actions) for each in patterns}}
    policy = _unambiguous(policy)
    ends = rng.choice(["", "success: [X1]\n", "success: ['1X']\nfailure: ['*1']\n"])
    lines = "".join(f"  '{pattern}': {action}\n" for pattern, action in policy.items())
    limits = "limits: {transitions: 12, transition_time: 5 s}\n"
    name = write(here, f"random_{seed}", f"{members}policy:\n{lines}{ends}{limits}")
    run, tree, _ = outcomes(name)
    assert run == tree


@pytest.mark.parametrize("file", PROGRAMS, ids=[file.stem for file in PROGRAMS])
def test_tree_of_every_shipped_program_is_built(file: Path) -> None:
    factory = behaviortreepy.BehaviorTreeFactory()
    for name, (kind, _) in LEAVES.items():
        is_condition = kind == "Condition"
        register = (
            factory.register_simple_condition if is_condition else factory.register_simple_action
        )
        register(name, lambda node: NodeStatus.SUCCESS)
    xml = behavior_tree(cbdsl.load(file).program)
    assert factory.create_tree_from_text(with_ports_in_names(xml)) is not None


def _unambiguous(policy: dict[str, str]) -> dict[str, str]:
    """Leave out patterns that are as close as others to a state, with another action."""
    from cbdsl.types.state import overlap

    kept: dict[str, str] = {}
    for pattern, action in policy.items():
        rivals = (
            each for each in kept
            if overlap(each, pattern) and each.count("*") == pattern.count("*")
        )  # fmt: skip
        if all(kept[each] == action for each in rivals):
            kept[pattern] = action
    return kept
