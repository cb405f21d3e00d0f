"""Live view of an exploration: each page gets the whole catalog, in every episode."""

from __future__ import annotations

import math
from typing import Any

import pytest

from cbdsl.learning.catalogs.action_outcome import ActionOutcome
from cbdsl.numeric.proportion import exact_interval
from cbdsl.reporting.live.exploration_view import ExplorationView
from cbdsl.reporting.live.feed import Feed, PageCursor
from cbdsl.reporting.live.live_view import LiveView
from cbdsl.reporting.live.transport import Transport
from tests.reporting.conftest import Shown
from tests.reporting.live.conftest import Watched
from tests.reporting.live.explored import PLACE, exploration, missed, nothing, reached
from tests.reporting.live.test_live_view import contents


@pytest.fixture
def feed() -> Feed:
    return Feed()


@pytest.fixture
def view(feed: Feed) -> ExplorationView:
    return ExplorationView(LiveView(feed, Transport(math.inf), Shown), "ball", "yellow", 9)


def catalog(cursor: PageCursor) -> Any:
    """Return the newest catalog that a page receives."""
    return [content for kind, content in contents(cursor) if kind == "catalog"][-1]


def explore(view: ExplorationView, *outcomes: ActionOutcome) -> Any:
    explored = exploration()
    for outcome in outcomes:
        view.note_choice(outcome.action)
        explored.note(outcome)
        view.note_step(explored)
    return explored


def test_counts_rewards_and_probabilities_are_those_of_the_exploration(
    feed: Feed, view: ExplorationView
) -> None:
    with feed.page() as cursor:
        explored = explore(view, reached(0.5), missed(0.9), reached(0.52), nothing())
        told = catalog(cursor)
    reach, lift = told["affordances"]
    assert (reach["name"], reach["rewarded"], reach["tried"]) == ("reach", 2, 3)
    assert reach["interval"] == pytest.approx(exact_interval(2, 3), rel=1e-5)
    assert reach["value"] == pytest.approx(explored.values["reach"], rel=1e-5)
    assert reach["change"] == pytest.approx(explored.change_of("reach"), rel=1e-5)
    assert (lift["tried"], lift["interval"], lift["model"]) == (0, None, "none")
    assert (told["over"], told["total"], told["noop"], told["chosen"]) == (4, 9, 1, "")
    course = told["course"]
    assert course["action"] == [step.action for step in explored.steps]
    assert course["reward"] == pytest.approx([s.reward for s in explored.steps], rel=1e-5)
    assert course["tried"]["reach"] == [1, 2, 3, 3] and course["tried"]["lift"] == [0] * 4
    assert "2 of 3" in told["icon"] and "lift" not in told["icon"]


def test_probability_uses_the_current_features(feed: Feed, view: ExplorationView) -> None:
    near, far = (reached(0.5), missed(0.9), reached(0.52), missed(0.88)), missed(0.9)
    with feed.page() as cursor:
        explored = explore(view, *near, reached(0.51))
        here = catalog(cursor)["affordances"][0]
        explored.note(far)
        view.note_step(explored)
        there = catalog(cursor)["affordances"][0]
        explored.note(nothing())
        view.note_step(explored)
        unseen = catalog(cursor)["affordances"][0]
    assert here["ahead"] and there["ahead"] and not unseen["ahead"]
    assert there["probability"] < 0.201  # 0.2 is the least: base rate 0.5, as 4 of 10 trials
    assert here["probability"] > 0.8
    assert unseen["probability"] == pytest.approx((3 + 1) / (6 + 2))


def test_catalog_stays_from_one_episode_to_the_next(
    feed: Feed, view: ExplorationView, watched: Watched
) -> None:
    explore(view, reached(0.5))
    view.note_choice("lift")
    watched(view)
    with feed.page() as late:
        told = contents(late)
    kinds = [kind for kind, _ in told]
    assert kinds[0] == "episode" and kinds.count("catalog") == 1
    content = dict(told)["catalog"]
    assert content["chosen"] == "lift" and content["affordances"][0]["rewarded"] == 1


def test_action_that_comes_later_has_no_course_before(feed: Feed, view: ExplorationView) -> None:
    explored = explore(view, reached(0.5))
    explored.add({"inspect": PLACE})
    explored.note(ActionOutcome("inspect", failed=True, ending="the hand is gone"))
    view.note_step(explored)
    with feed.page() as cursor:
        told = catalog(cursor)
    assert told["course"]["tried"]["inspect"] == [None, 1]
    assert told["affordances"][2]["model"] == "left out"


def test_course_keeps_only_the_last_actions(feed: Feed, view: ExplorationView) -> None:
    explore(view, *[nothing()] * 1003)
    with feed.page() as cursor:
        course = catalog(cursor)["course"]
    assert course["first"] == 4 and len(course["action"]) == len(course["tried"]["reach"]) == 1000
