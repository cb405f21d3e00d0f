"""The live view: it sends events immediately, and creates no messages without a page."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest

from cbdsl.reporting.live import live_view as module
from cbdsl.reporting.live.feed import Feed, PageCursor
from cbdsl.reporting.live.live_view import LiveView
from cbdsl.reporting.live.transport import Transport
from cbdsl.runtime.tick import Tick
from tests.reporting.conftest import Shown
from tests.reporting.live.conftest import Watched


def contents(cursor: PageCursor) -> list[tuple[str, Any]]:
    """Return new messages, as a page reads them."""
    events = [each.event.decode() for each in cursor.take(0.0)]
    return [(e.split("\n")[0][7:], json.loads(e.split("data: ", 1)[1])) for e in events]


@pytest.fixture
def feed() -> Feed:
    return Feed()


@pytest.fixture
def view(feed: Feed) -> LiveView:
    return LiveView(feed, Transport(math.inf), Shown)


def test_observer_receives_all_of_an_episode(
    feed: Feed, view: LiveView, watched: Watched, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_PAUSE", 0.0)
    told: list[tuple[str, Any]] = []
    truth: list[tuple[float, np.ndarray, str]] = []

    def look(tick: Tick) -> None:
        told.extend(contents(cursor))
        truth.append((tick.observation.time, tick.observation.positions.copy(), tick.run.state))

    with feed.page() as cursor:
        result = watched(view, each=look)
        told.extend(contents(cursor))
    of = {kind: [content for each, content in told if each == kind] for kind, _ in told}
    assert of["episode"][0]["members"]["reachtouch"] == ["searchtrack", "reach", "touch"]
    assert of["ending"][0]["ending"] == result.ending and of["ending"][0]["rewarded"]
    own = [each for each in of["transition"] if each["depth"] == 0]
    assert [each["next_state"] for each in own] == list(result.predicates[1:])
    frames = of["frame"]
    assert [each["time"] for each in frames] == sorted({round(t, 6) for t, _, _ in truth})
    for frame, (_, positions, state) in zip(frames, truth, strict=True):
        np.testing.assert_allclose(frame["positions"], positions, rtol=1e-5, atol=1e-6)
        assert frame["state"] == state
        assert frame["bodies"]["ball"][:3] == pytest.approx(Shown().position)
    names = of["controllers"][0]["names"]
    approach = [each["potentials"][names.index("approach")] for each in frames]
    defined = [phi for phi in approach if phi is not None]
    assert None in approach and defined[-1] < 0.01 * defined[0]
    stack = [names[level["controller"]] for level in frames[-1]["levels"]]
    assert stack.index("touch") < stack.index("approach") < stack.index("posture")
    assert set(of["body"][0]["parts"][0]) >= {"shape", "size", "color"}


def test_no_frame_is_made_without_a_viewer(
    feed: Feed, view: LiveView, watched: Watched, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[float] = []
    frame = module.frame
    monkeypatch.setattr(
        module,
        "frame",
        lambda tick, *more: made.append(tick.observation.time) or frame(tick, *more),
    )
    result = watched(view)
    assert len(made) == 1, "the end alone, for whoever comes then"
    with feed.page() as cursor:
        told = contents(cursor)
    kinds = [kind for kind, _ in told]
    assert kinds[0] == "episode" and kinds.count("transition") >= len(result.actions)
    assert told[-1][0] == "frame" and told[-1][1]["state"] == result.predicates[-1]


def test_watched_run_equals_an_unwatched_one(feed: Feed, view: LiveView, watched: Watched) -> None:
    alone = watched(view)
    with feed.page():
        seen = watched(view)
    assert (seen.predicates, seen.ticks, seen.ending) == (
        alone.predicates,
        alone.ticks,
        alone.ending,
    )


def test_frames_are_no_denser_than_eyes_need(feed: Feed, watched: Watched) -> None:
    now = [0.0]
    view = LiveView(feed, Transport(math.inf), clock=lambda: now[0])
    numbers: list[int] = []

    def pass_time(_: Tick) -> None:
        now[0] += 0.01
        numbers.extend(1 for kind, _ in contents(cursor) if kind == "frame")

    with feed.page() as cursor:
        result = watched(view, each=pass_time)
    assert result.ticks / 5 < len(numbers) < result.ticks / 3


def test_page_lists_the_episodes_before(feed: Feed, view: LiveView, watched: Watched) -> None:
    first = watched(view, seed=21)
    watched(view, seed=22)
    with feed.page() as cursor:
        header = contents(cursor)[0][1]
    assert (header["number"], header["seed"]) == (2, 22)
    assert [each["ending"] for each in header["past"]] == [first.ending]
