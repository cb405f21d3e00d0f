"""ASSIMILATE learns from attempts which allocation leads to reward where."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.checking.assimilation import program_to_assimilate
from cbdsl.checking.session import Session
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.learning.allocation_tree import TriedContext, grow_choice
from cbdsl.learning.assimilate import Assimilate, AssimilateConstants
from cbdsl.learning.experience import Experience
from cbdsl.learning.tree_growth import grow
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.transition import Transition
from cbdsl.types.decision_tree import Leaf, decide, splits
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

NAMES = ("place.x", "place.y", "place.z")


@pytest.fixture(scope="module")
def schema() -> CheckedProgram:
    library = Library(ROOT)
    policy = library.read(library.locate(PolicyDocument, "reachtouch"), PolicyDocument)
    path = library.locate(ProgramDocument, "reachtouch")
    return program_to_assimilate(path, policy, Session(library), {})


def features(schema: CheckedProgram, x: float, y: float) -> dict[str, float]:
    assert schema.schema is not None
    return {name: 0.0 for name in schema.schema.components} | {"place.x": x, "place.y": y}


def episode(schema: CheckedProgram, rng: np.random.Generator, allocation: str) -> Experience:
    """In a world in which either arm reaches its own side, and nothing beyond 1 m."""
    x, y = rng.uniform(0.3, 1.5), rng.uniform(-0.7, 0.7)
    tried = [allocation, "left_arm" if allocation == "right_arm" else "right_arm"]
    context, made = features(schema, x, y), []
    for arm in tried:
        rewarded = x < 1.0 and (y > 0) == (arm == "left_arm")
        after = "X11" if rewarded else "X1-"
        action = f"reach ◁ touch with {arm}"
        step = Transition(
            "reachtouch", 0, 1.0, "X0-", action, after, 60, int(rewarded), (), arm, context
        )
        made.append(step)
        if rewarded:
            break
    return Experience("here", 1, tuple(made), {}, 60, 1.0)


def taught(schema: CheckedProgram, episodes: int, seed: int = 1) -> Assimilate:
    learner, rng = Assimilate(["any"], AssimilateConstants()), np.random.default_rng(seed)
    learner.adopt(schema)
    for _ in range(episodes):
        learner.remember(episode(schema, rng, str(rng.choice(["left_arm", "right_arm"]))))
    return learner


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_side_decides_the_arm_and_the_distance_whether_there_is_reward(
    schema: CheckedProgram, seed: int
) -> None:
    learner, rng = taught(schema, 60, seed), np.random.default_rng(seed + 100)
    choice, reward = learner.choice(), learner.reward()
    right = far = 0
    for _ in range(500):
        x, y = rng.uniform(0.3, 1.5), rng.uniform(-0.7, 0.7)
        ranking = decide(choice, features(schema, x, y))
        right += ranking is not None and ranking[0] == ("left_arm" if y > 0 else "right_arm")
        likely = decide(reward, features(schema, x, y))
        far += likely is not None and (likely < 0.5) == (x > 1.0)
    assert right >= 475 and far >= 475
    assert {split.feature for split in splits(choice)} == {"place.y"}
    assert {split.feature for split in splits(reward)} == {"place.x"}


def test_what_was_seen_too_little_of_is_not_learned_from(schema: CheckedProgram) -> None:
    learner = Assimilate(["any"], AssimilateConstants())
    learner.adopt(schema)
    step = Transition("p", 0, 1.0, "X0-", "a", "X11", 5, 1, (), "left_arm", {"place.x": 1.0})
    learner.remember(Experience("here", 1, (step,), {}, 5, 1.0))
    assert learner.choice() == Leaf(()) and learner.reward() == Leaf(0.5)


def test_exploring_tries_both_where_the_best_is_known(schema: CheckedProgram) -> None:
    learner, rng = taught(schema, 60), np.random.default_rng(7)
    chosen = []
    for _ in range(300):
        policy = learner.policy(rng)
        policy.begin(lambda: features(schema, 0.5, 0.4))  # type: ignore[attr-defined]
        chosen.append(policy.choose("X0-", changed=True))
    share = chosen.count("reach ◁ touch with right_arm") / len(chosen)
    assert 0.05 < share < 0.16, "half of epsilon"


def certain(labels: str) -> np.ndarray:
    """Shares of samples whose labels are known."""
    kinds = sorted(set(labels))
    return np.array([[float(label == kind) for kind in kinds] for label in labels])


def test_leaves_hold_as_many_samples_as_asked_for() -> None:
    samples = [{"x": float(i)} for i in range(20)]
    shares = certain("aaaaaaab" + 12 * "a")
    assert len(list(splits(grow(samples, shares, tuple, 1)))) == 2
    for split in splits(grow(samples, shares, len, 5)):
        for side in (split.above, split.below):
            assert not isinstance(side, Leaf) or side.answer >= 5


def test_equal_labels_need_no_question() -> None:
    assert grow([{"x": 1.0}, {"x": 2.0}], certain("aa"), len, 1) == Leaf(2)
    assert grow([], np.zeros((0, 2)), len, 1) == Leaf(0)


def test_a_threshold_lies_between_its_neighbours() -> None:
    tree = grow([{"x": 0.0001}, {"x": 0.0002}], certain("ab"), tuple, 1)
    assert [split.threshold for split in splits(tree)] == [0.0001]
    assert decide(tree, {"x": 0.0001}) == (0,) and decide(tree, {"x": 0.0002}) == (1,)


def test_what_was_not_tried_is_no_failure() -> None:
    """Each arm reaches the other's side, too, as far as 0.3 m, where only one was tried."""
    rng = np.random.default_rng(5)
    contexts = []
    for _ in range(60):
        y = float(rng.uniform(-0.7, 0.7))
        works = {"right": y < 0.3, "left": y > -0.3}
        order = ["right", "left"] if rng.random() < 0.8 else ["left", "right"]
        tried = order[:1] if works[order[0]] else order
        context = {"y": y, "noise": float(rng.normal())}
        contexts.append(TriedContext(context, {name: works[name] for name in tried}))
    tree = grow_choice(contexts, ("right", "left"), 3)
    right = 0
    for y in np.linspace(-0.7, 0.7, 141):
        best = (decide(tree, {"y": float(y), "noise": 0.0}) or ("",))[0]
        right += {"right": y < 0.3, "left": y > -0.3}.get(best, False)
    assert right >= 134
