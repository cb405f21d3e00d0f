"""Requests that change a running program: carried out between ticks, or refused with a reason."""

from __future__ import annotations

import math
from collections.abc import Iterator
from threading import Thread
from typing import Any

import pytest

from cbdsl.reporting.live import transport as timing
from cbdsl.reporting.live.composed_program import Changes, ComposedProgram, composed_program
from cbdsl.reporting.live.feed import Feed
from cbdsl.reporting.live.live_view import LiveView
from cbdsl.reporting.live.page_server import RequestError
from cbdsl.reporting.live.requests import Requests
from cbdsl.reporting.live.transport import Transport
from cbdsl.runtime.program_composer import Composer
from tests.conftest import ROOT
from tests.reporting.live.conftest import Watched


def save(changes: Changes, name: str) -> ComposedProgram:
    return composed_program(ROOT / "programs" / "reachtouch.yaml", "table_right", {}, changes, name)


class Paused:
    """Run that waits in its first tick, in a separate thread."""

    def __init__(self, watched: Watched) -> None:
        self.transport, self.composer = Transport(math.inf), Composer()
        self.transport.pause()
        view = LiveView(Feed(), self.transport, None, self.composer)
        self.ask = Requests(self.transport, self.composer, save)
        self._thread = Thread(target=watched, args=(view,))
        self._thread.start()

    def end(self) -> None:
        if self.composer.stack is not None:
            self.ask({"do": "compose", "stack": None})
        self.transport.release()
        self._thread.join()


@pytest.fixture(scope="module")
def paused(watched: Watched) -> Iterator[Paused]:
    made = Paused(watched)
    yield made
    made.end()


def test_changes_are_made_and_saved(paused: Paused) -> None:
    ask = paused.ask
    assert ask({"do": "gain", "controller": "approach", "value": 3}) == {"gain": 3.0}
    ask({"do": "hold", "controller": "approach", "target": [0.4, -0.3, 0.1]})
    ask({"do": "compose", "stack": ["approach", "orient"]})
    saved = ask({"do": "save", "name": "mine"})
    assert "gain: 3 /s" in saved["text"] and "orient ◁ approach" in saved["text"]
    assert (saved["findings"], saved["left_out"]) == ([], [])
    ask({"do": "hold", "controller": "approach", "target": None})
    ask({"do": "compose", "stack": None})
    assert paused.composer.targets == {} and paused.composer.stack is None


@pytest.mark.parametrize(
    ("request_", "words"),
    [
        ({"do": "gain", "controller": "approach"}, "value: None is not a number"),
        ({"do": "gain", "controller": 1, "value": 1}, "controller: 1 is not text"),
        ({"do": "gain", "controller": "approach", "value": -1}, "above 0"),
        ({"do": "hold", "controller": "approach", "target": "here"}, "not a list of numbers"),
        ({"do": "hold", "controller": "approach", "target": [1, 2, True]}, "not a number"),
        ({"do": "hold", "controller": "approach", "target": [1, 2]}, "three numbers"),
        ({"do": "compose", "stack": "approach"}, "not a list of controllers"),
        ({"do": "compose", "stack": [["approach"]]}, "not a list of controllers"),
        ({"do": "compose", "stack": ["reach"]}, "unknown controller 'reach'"),
        ({"do": "save", "name": "../mine"}, "not a name of a program"),
        ({"do": "save"}, "name: None is not text"),
    ],
    ids=str,
)
def test_impossible_request_is_refused_with_a_reason(
    paused: Paused, request_: dict[str, Any], words: str
) -> None:
    with pytest.raises(RequestError) as caught:
        paused.ask(request_)
    assert words in str(caught.value)


def test_requests_without_a_composer_exclude_changes() -> None:
    with pytest.raises(RequestError, match="known: pause, continue, step, speed"):
        Requests(Transport())({"do": "gain", "controller": "approach", "value": 1})


def test_between_episodes_nothing_can_be_changed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(timing, "_PATIENCE", 0.01)
    with pytest.raises(RequestError, match="no episode runs"):
        Requests(Transport(), Composer(), save)({"do": "compose", "stack": ["approach"]})
