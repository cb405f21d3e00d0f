"""ASSIMILATE learns from attempts which allocation leads to reward where."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.checking.assimilation import program_to_assimilate
from cbdsl.checking.session import Session
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.schema import ChoiceQuestion, RewardQuestion
from cbdsl.learning.allocation_tree import Tally, TriedContext, grow_tallies, rankings
from cbdsl.learning.assimilate import Assimilate, AssimilateConstants
from cbdsl.learning.experience import Experience
from cbdsl.learning.tree_growth import Outcomes, grow
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.transition import Transition
from cbdsl.types.decision_tree import Leaf, Split, decide, splits
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
    return dict.fromkeys(schema.schema.components, 0.0) | {"place.x": x, "place.y": y}


def episode(schema: CheckedProgram, rng: np.random.Generator, allocation: str) -> Experience:
    """Run an episode in which either arm reaches its own side, and nothing beyond 1 m."""
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


def taught(
    schema: CheckedProgram, episodes: int, seed: int = 1, *, draws: bool = True
) -> Assimilate:
    learner = Assimilate(["any"], AssimilateConstants(draws=draws))
    rng = np.random.default_rng(seed)
    learner.adopt(schema)
    for _ in range(episodes):
        learner.remember(episode(schema, rng, str(rng.choice(["left_arm", "right_arm"]))))
    return learner


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_side_decides_the_arm_and_the_distance_whether_there_is_reward(
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


def test_context_with_undefined_features_is_not_learned_from(schema: CheckedProgram) -> None:
    learner = Assimilate(["any"], AssimilateConstants())
    learner.adopt(schema)
    step = Transition("p", 0, 1.0, "X0-", "a", "X11", 5, 1, (), "left_arm", {"place.x": 1.0})
    learner.remember(Experience("here", 1, (step,), {}, 5, 1.0))
    assert learner.choice() == Leaf(()) and learner.reward() == Leaf(0.5)


def chosen_first(learner: Assimilate, schema: CheckedProgram, times: int) -> list[str]:
    """Return the first choices on the left, in some episodes."""
    rng, chosen = np.random.default_rng(7), []
    for _ in range(times):
        policy = learner.policy(rng)
        context = features(schema, 0.5, 0.4)
        chosen.append(policy.choose("X0-", changed=True, features=context).allocation)
    return chosen


def test_worse_allocation_is_tried_less_with_more_samples(
    schema: CheckedProgram,
) -> None:
    early, late = (chosen_first(taught(schema, n), schema, 300) for n in (6, 200))
    assert early.count("left_arm") < late.count("left_arm")
    assert 250 < late.count("left_arm") < 300, "now and then another one"
    assert {"right_arm", "reachtouch_bimanual"} <= set(early)


def test_epsilon_tries_both_where_the_best_is_known(schema: CheckedProgram) -> None:
    learner = taught(schema, 60, draws=False)
    share = chosen_first(learner, schema, 300).count("right_arm") / 300
    assert 0.03 < share < 0.12, "a third of epsilon"


def certain(labels: str) -> Outcomes:
    """Return outcomes of one kind of trial, successes for the label a."""
    successes = np.array([[float(label == "a")] for label in labels]).reshape(len(labels), 1)
    return Outcomes(successes, 1.0 - successes)


def test_leaves_hold_as_many_samples_as_asked_for() -> None:
    samples = [{"x": float(i + 100 * (i > 11) + 100 * (i > 19))} for i in range(32)]
    outcomes = certain(12 * "a" + 8 * "b" + 12 * "a")
    assert len(list(splits(grow(samples, outcomes, tuple, 1)))) == 2
    for least in (1, 3, 5):
        for split in splits(grow(samples, outcomes, len, least)):
            for side in (split.above, split.below):
                assert not isinstance(side, Leaf) or side.answer >= least


def test_single_differing_sample_gives_no_split() -> None:
    samples = [{"x": float(i)} for i in range(20)]
    assert grow(samples, certain(7 * "a" + "b" + 12 * "a"), len, 1) == Leaf(20)


def test_wide_gap_is_preferred_to_a_narrow_one() -> None:
    """Prefer, of features that separate equally well, the one observed on two sides alone."""
    samples = [{"x": 0.1 * i, "y": float(i > 9)} for i in range(20)]
    (split,) = splits(grow(samples, certain(10 * "a" + 10 * "b"), tuple, 1))
    assert (split.feature, split.threshold) == ("y", 0.5)


@pytest.mark.parametrize("labels", ["aaaaabbbbb", "bbbbbaaaaa"])
@pytest.mark.parametrize("trust", [0.5, 0.7])
def test_threshold_leaves_the_gap_to_the_rewarded_side(labels: str, trust: float) -> None:
    samples = [{"x": float(i + 10 * (i > 4))} for i in range(10)]
    (split,) = splits(grow(samples, certain(labels), tuple, 1, trust=trust))
    share = (split.threshold - 4.0) / 11.0
    assert share == pytest.approx(trust if labels.startswith("a") else 1 - trust, abs=1e-4)


def test_untried_allocation_is_preferred_to_giving_up(schema: CheckedProgram) -> None:
    learner = Assimilate(["any"], AssimilateConstants())
    learner.adopt(schema)
    for x in (0.5, 0.55, 0.6, 0.65, 0.7, 1.2, 1.25, 1.3, 1.35, 1.4):
        action, after = ("reach ◁ touch with left_arm", "X11" if x < 1 else "X1-")
        step = Transition(
            "p",
            0,
            1.0,
            "X0-",
            action,
            after,
            5,
            int(x < 1),
            (),
            "left_arm",
            features(schema, x, 0.3),
        )
        learner.remember(Experience("here", 1, (step,), {}, 5, 1.0))
    (split,) = splits(learner.reward())
    assert split.threshold == pytest.approx(0.7 + 0.7 * 0.5, abs=1e-3)


@pytest.mark.parametrize("blames_first", [False, True])
def test_failure_caused_by_an_earlier_attempt_is_not_counted(
    schema: CheckedProgram, blames_first: bool
) -> None:
    """Move objects with the left arm, tried first, so that the right one, tried next, fails too."""
    learner = Assimilate(["any"], AssimilateConstants(blames_first=blames_first))
    learner.adopt(schema)
    here = features(schema, 0.5, -0.3)
    right = TriedContext(here, {"right_arm": True})
    spoilt = TriedContext(here, {"left_arm": False, "right_arm": False})
    alone = TriedContext(here, {"left_arm": False})
    learner.recall([right] * 4 + [spoilt] * 6 + [alone] * 3)
    chance = 5 / 6 if blames_first else 5 / 12
    assert learner.reward() == Leaf(round(chance, 3))


@pytest.mark.parametrize(("each", "sides"), [(3, 2), (2, 1)])
def test_sides_on_which_others_worked_are_distinguished_before_any_has_failed(
    schema: CheckedProgram, each: int, sides: int
) -> None:
    """Three contexts a side are enough; two are not."""
    learner = Assimilate(["any"], AssimilateConstants())
    learner.adopt(schema)
    for number in range(each):
        for arm, side in (("left_arm", 1.0), ("right_arm", -1.0)):
            here = features(schema, 0.5, side * (0.5 + 0.1 * number))
            learner.recall([TriedContext(here, {arm: True})])
    choice = learner.choice()
    found = {(decide(choice, features(schema, 0.5, y)) or ("",))[0] for y in (-0.6, 0.6)}
    assert len(found) == sides


def test_equal_labels_need_no_question() -> None:
    assert grow([{"x": 1.0}, {"x": 2.0}], certain("aa"), len, 1) == Leaf(2)
    assert grow([], certain(""), len, 1) == Leaf(0)


def test_threshold_lies_between_its_neighbours() -> None:
    samples = 4 * [{"x": 0.0001}] + 4 * [{"x": 0.0002}]
    tree = grow(samples, certain("aaaabbbb"), tuple, 1)
    assert [split.threshold for split in splits(tree)] == [0.0001]
    assert decide(tree, {"x": 0.0001}) == (0, 1, 2, 3)
    assert decide(tree, {"x": 0.0002}) == (4, 5, 6, 7)


def rightly_chosen(rng: np.random.Generator) -> int:
    """Count the places, of 141, for which the tree of 60 contexts has a reaching arm first."""
    contexts = []
    for _ in range(60):
        y = float(rng.uniform(-0.7, 0.7))
        works = {"right": y < 0.3, "left": y > -0.3}
        order = ["right", "left"] if rng.random() < 0.8 else ["left", "right"]
        tried = order[:1] if works[order[0]] else order
        context = {"y": y, "noise": float(rng.normal())}
        contexts.append(TriedContext(context, {name: works[name] for name in tried}))
    tree = rankings(grow_tallies(contexts, ("right", "left"), 2), ("right", "left"))
    right = 0
    for y in np.linspace(-0.7, 0.7, 141):
        best = (decide(tree, {"y": float(y), "noise": 0.0}) or ("",))[0]
        right += {"right": y < 0.3, "left": y > -0.3}.get(best, False)
    return right


def test_untried_allocation_does_not_count_as_failed() -> None:
    """Either arm reaches 0.3 m into the other's side, where only one was tried."""
    right = sum(rightly_chosen(np.random.default_rng(seed)) for seed in range(5))
    assert right >= 0.95 * 5 * 141


def test_leaves_with_the_same_first_allocation_are_one() -> None:
    """Merge leaves that differ only in the second allocation."""
    contexts = [
        TriedContext({"y": float(i)}, {"left": True, "right": i > 9, "both": i <= 9})
        for i in range(20)
    ]
    names = ("left", "right", "both")
    tallies = grow_tallies(contexts, names, 2)
    assert len(list(splits(tallies))) == 1
    assert rankings(tallies, names) == Leaf(("left", "right", "both"))


def test_tally_ranks_by_probability_and_omits_failures() -> None:
    tally = Tally((3.0, 2.0, 0.0), (3.0, 0.0, 1.0))
    assert tally.ranking(("a", "b", "c")) == ("b", "a")
    rng = np.random.default_rng(1)
    first = [tally.drawn(("a", "b", "c"), rng)[0] for _ in range(400)]
    assert first.count("b") > first.count("a") > first.count("c") > 0


def test_first_attempt_is_to_blame_where_nothing_was_rewarded(schema: CheckedProgram) -> None:
    """Blame the first attempt, because later ones find the object where the first has left it."""
    left, right = (TriedContext({"x": x}, {"a": x > 0}) for x in (0.4, -0.4))
    spoiled = TriedContext({"x": -0.5}, {"a": False, "b": False})
    names = ("a", "b")
    silent = grow_tallies([left, left, spoiled, spoiled], names, 2)
    assert decide(silent, {"x": -0.5}) == Tally((2.0, 0.0), (0.0, 0.0))
    blamed = [each if each.rewarded else each.first_alone() for each in (spoiled, right)]
    tree = grow_tallies([left, left, *blamed], names, 2)
    assert decide(tree, {"x": -0.5}) == Tally((0.0, 0.0), (2.0, 0.0)), "b was not to blame"
    assert decide(tree, {"x": 0.5}) == Tally((2.0, 0.0), (0.0, 0.0))


@pytest.mark.parametrize("blames", [True, False])
def test_blames_first_decides_which_attempt_is_blamed(schema: CheckedProgram, blames: bool) -> None:
    learner = Assimilate(["any"], AssimilateConstants(blames_first=blames))
    learner.adopt(schema)
    here, there = features(schema, 0.5, 0.4), features(schema, 0.5, -0.4)
    won = TriedContext(here, {"left_arm": True})
    lost = TriedContext(there, {"left_arm": False, "right_arm": False})
    learner.recall([won, won, lost, lost])
    rank = learner.ranking(np.random.default_rng(1))
    firsts = [rank(there)[0] for _ in range(200)]
    assert (firsts.count("left_arm") < 50) is blames


def test_written_schema_has_the_questions_of_the_grown_trees(schema: CheckedProgram) -> None:
    """Write each question with the unit of its feature, and name features by parameters."""
    learner = taught(schema, 60)
    written = learner.document("mine", schema)
    (choice,), (reward,) = splits(learner.choice()), splits(learner.reward())
    assert isinstance(written.choose, ChoiceQuestion)
    assert written.choose.if_ == f"place.y > {choice.threshold:g} m"
    assert (written.choose.then, written.choose.else_) == ("left_arm", "right_arm")
    assert isinstance(written.reward, RewardQuestion)
    assert written.reward.if_ == f"place.x > {reward.threshold:g} m"
    likely = [decide(learner.reward(), features(schema, x, 0.1)) for x in (1.4, 0.4)]
    assert [written.reward.then, written.reward.else_] == likely
    assert written.least_reward == AssimilateConstants().least_reward
    assert (written.name, written.program) == ("mine", "reachtouch")
    assert schema.schema is not None
    assert written.otherwise == tuple(written.allocations) == tuple(schema.schema.allocations)
    assert written.features.keys() == schema.schema.features.keys()
    assert written.actions["reach"].potential == schema.primitives["reach"].lead.potential
    assert written.look.keys() == schema.looks.keys()


def test_contexts_are_rounded_to_the_resolution_of_their_features(schema: CheckedProgram) -> None:
    learner = Assimilate(["any"], AssimilateConstants())
    learner.adopt(schema)
    assert schema.schema is not None
    seen = dict.fromkeys(schema.schema.components, 0.0)
    seen |= {"place.x": 0.4049, "place.y": -0.4051, "velocity.x": 0.031, "volume": 0.0016}
    step = Transition("reachtouch", 0, 1.0, "X0-", "a", "X11", 5, 1, (), "left_arm", seen)
    learner.remember(Experience("here", 1, (step,), {}, 5, 1.0))
    (context,) = learner.contexts
    assert {name: context.features[name] for name in seen} == pytest.approx(
        seen | {"place.x": 0.40, "place.y": -0.41, "velocity.x": 0.04, "volume": 0.002}
    )
    assert context.outcomes == {"left_arm": True}


def test_learner_without_a_schema_chooses_the_first_action() -> None:
    learner = Assimilate(["some", "other"], AssimilateConstants())
    assert learner.policy(np.random.default_rng(0)).choose("X", changed=True).action == "some"
    assert learner.greedy() == {} and learner.densities() == {}
    assert not learner.contexts


def test_unknown_context_draws_every_order_of_allocations(schema: CheckedProgram) -> None:
    learner = Assimilate(["any"], AssimilateConstants())
    learner.adopt(schema)
    rank, here = learner.ranking(np.random.default_rng(0)), features(schema, 0.5, 0.4)
    assert schema.schema is not None
    orders = {rank(here) for _ in range(100)}
    assert len(orders) == 6 and all(set(each) == set(schema.schema.allocations) for each in orders)


def test_drawn_ranking_of_a_tally_follows_the_beta_distribution() -> None:
    """Draw the second of chances with densities 1 and 2 x as the larger one in 2 of 3 cases."""
    tally, rng = Tally((0.0, 1.0), (0.0, 0.0)), np.random.default_rng(4)
    second = sum(tally.drawn(("a", "b"), rng)[0] == "b" for _ in range(4000))
    assert second / 4000 == pytest.approx(2 / 3, abs=0.025)
    tally = Tally((0.0, 0.0), (0.0, 1.0))
    second = sum(tally.drawn(("a", "b"), rng)[0] == "b" for _ in range(4000))
    assert second / 4000 == pytest.approx(1 / 3, abs=0.025)


def test_few_successes_are_weighed_against_none_by_laplace_s_rule() -> None:
    """1 of 1 is 2/3, 2 of 3 is 3/5, and 5 of 7 is between them."""
    names = ("two_of_three", "five_of_seven", "one_of_one", "five_of_six")
    tally = Tally((2.0, 5.0, 1.0, 5.0), (1.0, 2.0, 0.0, 1.0))
    assert tally.ranking(names) == ("five_of_six", "five_of_seven", "one_of_one", "two_of_three")


def test_leaf_is_not_merged_with_a_sibling_split() -> None:
    leaf = Leaf(Tally((2.0, 0.0), (0.0, 2.0)))
    other = Leaf(Tally((0.0, 2.0), (2.0, 0.0)))
    tree = Split("x", 1.0, leaf, Split("y", 2.0, leaf, other))
    assert [each.feature for each in splits(rankings(tree, ("a", "b")))] == ["x", "y"]


def test_tally_tree_of_no_samples_is_an_empty_leaf() -> None:
    assert grow_tallies([], ("a", "b"), 1) == Leaf(Tally((0.0, 0.0), (0.0, 0.0)))


@pytest.mark.parametrize(("last", "asked"), [(1.9, False), (2.1, True)])
def test_evidence_decides_whether_a_question_is_asked(last: float, asked: bool) -> None:
    """Compute by hand: of a, a and b the gap before b counts, which has to be half of all.

    Their chance is 2! 1! / 4! without the question, and 2! / 3! times 1! / 2! with it, twice that.
    """
    samples = [{"x": 0.0}, {"x": 1.0}, {"x": last}]
    tree = grow(samples, certain("aab"), tuple, 1)
    assert [split.threshold for split in splits(tree)] == ([(1 + last) / 2] if asked else [])


def test_equally_good_splits_use_the_first_feature() -> None:
    samples = [{"x": float(i > 3), "y": float(i > 3)} for i in range(8)]
    (split,) = splits(grow(samples, certain("aaaabbbb"), tuple, 1))
    assert split.feature == "x"


def test_constant_feature_does_not_hide_later_features() -> None:
    samples = [{"same": 1.0, "y": float(i > 3)} for i in range(8)]
    (split,) = splits(grow(samples, certain("aaaabbbb"), tuple, 1))
    assert (split.feature, split.threshold) == ("y", 0.5)


def test_threshold_separates_different_values() -> None:
    """Ask no question between equal numbers, however well it would separate their labels."""
    samples = [{"x": x, "same": 1.0} for x in (0.0, 0.0, 0.0, 0.0, 1.0, 1.0)]
    with np.errstate(all="raise"):
        tree = grow(samples, certain("aaabbb"), tuple, 1)
    assert tree == Split("x", 0.5, Leaf((4, 5)), Leaf((0, 1, 2, 3)))


def test_neighbours_that_measuring_does_not_distinguish_have_no_gap() -> None:
    """Noise of one step, which falls as the labels do, is asked before a wide gap without that."""
    samples = [{"noise": 0.02 * (i > 3), "y": i + 6.0 * (i > 3)} for i in range(8)]
    labels = certain("aaaabbbb")
    (split,) = splits(grow(samples, labels, tuple, 1))
    assert split.feature == "noise"
    (split,) = splits(grow(samples, labels, tuple, 1, {"noise": 0.02}))
    assert split.feature == "y"
    assert grow(
        [{"noise": each["noise"]} for each in samples], labels, len, 1, {"noise": 0.02}
    ) == (Leaf(8))


def test_attempts_of_an_episode_belong_to_its_first_context(
    schema: CheckedProgram,
) -> None:
    learner = Assimilate(["any"], AssimilateConstants())
    learner.adopt(schema)
    first, then = features(schema, 0.5, 0.4), features(schema, 0.7, -0.3)
    made = (
        Transition("reachtouch", 0, 1.0, "X0-", "a", "X0-", 5, 0, (), "left_arm", first),
        Transition("reachtouch", 0, 2.0, "X0-", "a", "X11", 5, 1, (), "right_arm", then),
    )
    learner.remember(Experience("here", 1, made, {}, 5, 1.0))
    (context,) = learner.contexts
    assert context.features["place.x"] == pytest.approx(0.5)
    assert context.outcomes == {"left_arm": False, "right_arm": True}


def test_likelihoods_are_reported_in_thousandths(schema: CheckedProgram) -> None:
    learner = Assimilate(["any"], AssimilateConstants())
    learner.adopt(schema)
    here = features(schema, 0.5, 0.4)
    learner.recall([TriedContext(here, {"left_arm": number < 4}) for number in range(5)])
    assert learner.reward() == Leaf(0.714)


def test_ranking_of_several_is_written_whole(schema: CheckedProgram) -> None:
    learner = Assimilate(["any"], AssimilateConstants())
    learner.adopt(schema)
    here, both = features(schema, 0.5, 0.4), {"left_arm": True, "right_arm": True}
    learner.recall([TriedContext(here, both), TriedContext(here, {"left_arm": True})])
    assert learner.document("mine", schema).choose == ("left_arm", "right_arm")


def test_learner_tries_allocations_without_predicted_reward(schema: CheckedProgram) -> None:
    """Try an allocation while learning, even if reward seems out of reach."""
    learner = Assimilate(["any"], AssimilateConstants())
    learner.adopt(schema)
    here = features(schema, 0.5, 0.4)
    learner.recall([TriedContext(here, {"left_arm": False}) for _ in range(20)])
    policy = learner.policy(np.random.default_rng(1))
    assert policy.choose("X0-", changed=True, features=here).allocation


def test_features_include_the_distance_from_the_group_of_reaching_arms(
    schema: CheckedProgram,
) -> None:
    assert schema.schema is not None
    assert schema.schema.features["distance"].name == "stereo.sat_10.from.arms"
    assert "distance" in schema.schema.components


def test_reward_splits_once_at_a_radial_limit_of_reach(schema: CheckedProgram) -> None:
    """Nothing is rewarded beyond 1 m from the nearer of two shoulders."""
    rng, learner = np.random.default_rng(2), Assimilate(["any"], AssimilateConstants())
    learner.adopt(schema)
    for _ in range(200):
        x, y = rng.uniform(0.1, 1.3), rng.uniform(-1.3, 1.3)
        distance = round(min(float(np.hypot(x, y - side)) for side in (-0.2, 0.2)), 2)
        context = features(schema, x, y) | {"distance": distance}
        learner.recall([TriedContext(context, {"right_arm": distance < 1.0}, counts=True)])
    reward = learner.reward()
    assert isinstance(reward, Split) and reward.feature == "distance"
    assert reward.threshold == pytest.approx(1.0, abs=0.05)
    assert [split.feature for split in splits(reward)] == ["distance"]


def test_document_states_the_ranges_that_were_tried(schema: CheckedProgram) -> None:
    learner = Assimilate(["any"], AssimilateConstants())
    learner.adopt(schema)
    for x in (0.4, 1.2):
        learner.recall([TriedContext(features(schema, x, 0.0), {"right_arm": True})])
    tried = learner.document("mine", schema).tried
    assert schema.schema is not None
    assert tried.keys() == set(schema.schema.components)
    # Features are rounded to 1 cm, so that each stands for values on both sides of it.
    assert tried["place.x"] == (0.395, 1.205)
