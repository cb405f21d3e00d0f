"""ACCOMMODATE learns from experience, and nothing but the experience matters."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.documents.model import Kernel
from cbdsl.learning.accommodate import Accommodate
from cbdsl.learning.constants import AccommodateConstants
from cbdsl.learning.experience import Experience
from cbdsl.learning.learner import replay
from cbdsl.program.transition import Transition
from tests.learning.conftest import Made

ACTIONS = ("search", "track")


def experience(transitions: tuple[Transition, ...], head: tuple[float, ...]) -> Experience:
    return Experience("here", 1, transitions, {"head": head}, 9, 0.15)


def knowledge(learner: Accommodate) -> object:
    return dict(learner.values.items()), dict(learner.counts.items()), learner.densities()


def test_rewarded_transition_ends_its_episode(made: Made) -> None:
    learner = Accommodate(ACTIONS, AccommodateConstants(alpha=1.0))
    learner.see(made("X1", "search", "0X"))
    learner.see(made("0X", "track", "X1"))
    # Were the episode to go on, X1 would be worth something: the first transition leads there.
    learner.see(made("X1", "search", "0X"))
    learner.see(made("0X", "track", "X1"))
    assert learner.values.value("X1", "search") == pytest.approx(0.8)
    assert learner.values.value("0X", "track") == pytest.approx(1.0)


def test_replayed_experience_is_the_same_knowledge(made: Made) -> None:
    first = (made("XX", "track", "X-"), made("X-", "search", "0X"), made("0X", "track", "X1"))
    second = (made("XX", "track", "X-"), made("X-", "track", "X-"), made("X-", "search", "0X"))
    lived, told = (
        Accommodate(ACTIONS, AccommodateConstants()),
        Accommodate(ACTIONS, AccommodateConstants()),
    )
    for transitions in (first, second, first):
        for transition in transitions:
            lived.see(transition)
        lived.remember(experience(transitions, (0.1, 0.2)))
        replay(told, experience(transitions, (0.1, 0.2)))
    assert knowledge(told) == knowledge(lived)


def test_learner_searches_unseen_objects_and_tracks_seen_ones(
    made: Made,
) -> None:
    learner, rng = Accommodate(ACTIONS, AccommodateConstants()), np.random.default_rng(5)
    for _ in range(200):
        state = "XX"
        explorer = learner.policy(rng)
        while state != "X1":
            action = explorer.choose(state, changed=True).action
            seen = state in ("X0", "1X") or (state == "XX" and rng.random() < 0.5)
            after = "1X" if action == "search" else "X-" if not seen else "X0"
            after = "X1" if (state, action) == ("X0", "track") else after
            learner.see(made(state, action, after))
            state = after
    greedy = learner.greedy()
    assert greedy == {
        "XX": "track",
        "X-": "search",
        "1X": "track",
        "X0": "track",
        "**": "search",
    }


@pytest.mark.parametrize(("finished", "explores"), [(0, True), (1, True), (2, False), (3, False)])
def test_learner_explores_only_in_exploring_episodes(
    finished: int, explores: bool, made: Made
) -> None:
    rewarded = (made("XX", "track", "X1"),)
    learner = Accommodate(ACTIONS, AccommodateConstants(epsilon=1.0, exploring_episodes=2))
    for transition in rewarded:
        learner.see(transition)
    for _ in range(finished):
        learner.remember(experience(rewarded, (0.1, 0.2)))
    explorer = learner.policy(np.random.default_rng(0))
    chosen = {explorer.choose("XX", changed=True).action for _ in range(50)}
    assert chosen == (set(ACTIONS) if explores else {"track"})


def test_program_among_the_actions_is_one_action_until_it_ends(made: Made) -> None:
    learner = Accommodate(("find", "track"), AccommodateConstants(alpha=1.0), {0: "find"})
    explorer = learner.policy(np.random.default_rng(0))
    for _ in range(2):
        for step in (("XX", "find", "0X"), ("0X", "find", "1X"), ("1X", "track", "X1")):
            learner.see(made(*step))
    # Its run time is not discounted, and no other action is chosen during it.
    assert learner.values.value("XX", "find") == pytest.approx(0.8)
    assert {explorer.choose("0X", changed=True).action for _ in range(50)} == {"find"}
    assert learner.greedy() == {"XX": "find", "0X": "find", "1X": "track", "**": "find"}
    assert dict(learner.counts.items())["0X"] == {"find": {"1X": 2}}


def test_program_that_the_end_of_an_episode_cut_short_is_worth_nothing(made: Made) -> None:
    learner = Accommodate(("find", "track"), AccommodateConstants(alpha=1.0), {0: "find"})
    learner.see(made("XX", "find", "0X"))
    learner.see(made("1X", "track", "X1"))
    assert learner.values.value("XX", "find") == 0.0
    assert learner.values.value("1X", "track") == 1.0


def test_effector_without_reward_has_no_density(made: Made) -> None:
    learner = Accommodate(ACTIONS, AccommodateConstants())
    replay(learner, Experience("here", 1, (made("XX", "track", "X-"),), {}, 9, 0.15))
    assert learner.densities() == {}


def test_policy_covers_the_states_in_which_something_was_tried_and_then_all_others(
    made: Made,
) -> None:
    learner = Accommodate(ACTIONS, AccommodateConstants())
    replay(learner, experience((made("XX", "track", "X0"), made("X0", "track", "X1")), (0, 0)))
    assert learner.greedy() == {"XX": "search", "X0": "track", "**": "search"}
    assert Accommodate(ACTIONS, AccommodateConstants()).greedy() == {}
    assert learner.policy(np.random.default_rng(0)).choose("--", changed=False).action in ACTIONS


def test_densities_are_of_the_configurations_that_were_rewarded_by_effector(made: Made) -> None:
    learner = Accommodate(ACTIONS, AccommodateConstants(bandwidth=0.3, prior=6.0))
    won = (made("XX", "track", "X1"),)
    for head in ((0.1, 0.2), (0.3, 0.4)):
        learner.remember(experience(won, head))
    learner.remember(Experience("here", 1, won, {"right_arm": (0.5,)}, 9, 0.15))
    densities = learner.densities()
    assert list(densities) == ["head", "right_arm"]
    head, arm = densities["head"], densities["right_arm"]
    assert isinstance(head, Kernel) and isinstance(arm, Kernel)
    assert head.samples == ((0.1, 0.2), (0.3, 0.4)) and arm.samples == ((0.5,),)
    assert head.bandwidth == (0.3, 0.3)
    assert (head.uniform, arm.uniform) == pytest.approx((6 / 8, 6 / 7))
