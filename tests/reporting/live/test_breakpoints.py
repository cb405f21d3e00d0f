"""Breakpoints: a run pauses at each chosen step and exit, and only there."""

from __future__ import annotations

import math
from collections.abc import Iterator
from threading import Thread

import pytest

from cbdsl.program.transition import Transition
from cbdsl.reporting.live.breakpoints import Breakpoints
from cbdsl.reporting.live.feed import Feed
from cbdsl.reporting.live.live_view import LiveView
from cbdsl.reporting.live.page_server import RequestError
from cbdsl.reporting.live.requests import Requests
from cbdsl.reporting.live.transport import Transport
from cbdsl.runtime.tick import Tick
from tests.conftest import Checked
from tests.reporting.live.conftest import Watched
from tests.reporting.live.test_transport import until

STEP, EXIT = "reach ◁ touch", "searchtrack -> reach ◁ touch"


class Met(LiveView):
    """View that keeps the places that its run passes, and never pauses."""

    def __init__(self, breakpoints: Breakpoints) -> None:
        super().__init__(Feed(), Transport(math.inf), breakpoints=breakpoints)
        self.met: list[tuple[float, str]] = []
        self.transitions: list[Transition] = []
        self._transport.release()

    def note_transition(self, transition: Transition) -> None:
        super().note_transition(transition)
        self.transitions.append(transition)

    def note_tick(self, tick: Tick) -> None:
        super().note_tick(tick)
        if self._breakpoints.met:
            self.met.append((tick.observation.time, self._breakpoints.met))


def test_breakpoints_list_steps_exits_and_those_of_used_programs(checked: Checked) -> None:
    breakpoints = Breakpoints()
    breakpoints.follow(checked("reachtouch"))
    assert {STEP, EXIT, "searchtrack.search", "searchtrack.track -> search"} <= set(
        breakpoints.places
    )
    assert "reach" not in breakpoints.places, "the policy never chooses it"


@pytest.mark.parametrize("place", [STEP, EXIT, "searchtrack.search ◁ track"])
def test_run_meets_a_breakpoint_where_its_transitions_lead(place: str, watched: Watched) -> None:
    breakpoints = Breakpoints()
    view = Met(breakpoints)
    watched(view, each=lambda _: breakpoints.choose([place]) if not view.met else None)
    assert {met for _, met in view.met} == {place}
    changes = {each.time for each in view.transitions} | {0.0}
    assert {time for time, _ in view.met} <= changes


def test_next_change_pauses_once(watched: Watched) -> None:
    breakpoints = Breakpoints()
    view = Met(breakpoints)
    breakpoints.wait_for_change()
    watched(view)
    assert len(view.met) == 1


def test_place_that_an_edit_removes_stays_chosen(checked: Checked) -> None:
    breakpoints = Breakpoints()
    breakpoints.follow(checked("reachtouch"))
    breakpoints.choose([EXIT])
    breakpoints.follow(checked("poise"))
    breakpoints.choose([EXIT])
    assert breakpoints.chosen == {EXIT}
    with pytest.raises(ValueError, match="no step or exit 'touch'"):
        breakpoints.choose([EXIT, "touch"])


class PausedRun:
    """Run in a thread that pauses at a breakpoint."""

    def __init__(self, watched: Watched, checked: Checked) -> None:
        self.transport, breakpoints = Transport(math.inf), Breakpoints()
        breakpoints.follow(checked("reachtouch"))
        self.ask = Requests(self.transport, breakpoints=breakpoints)
        self.ask({"do": "break", "at": [EXIT]})
        self.view = LiveView(Feed(), self.transport, breakpoints=breakpoints)
        self.ended: list[BaseException] = []
        self.thread = Thread(target=self._run, args=(watched,))
        self.thread.start()

    def _run(self, watched: Watched) -> None:
        try:
            watched(self.view)
        except BaseException as error:
            self.ended.append(error)


@pytest.fixture
def paused(watched: Watched, checked: Checked) -> Iterator[PausedRun]:
    made = PausedRun(watched, checked)
    yield made
    made.transport.release()
    made.thread.join()


def test_run_pauses_at_a_breakpoint_and_returns_to_an_earlier_time(paused: PausedRun) -> None:
    until(lambda: paused.transport.paused)
    assert paused.view._breakpoints.met == EXIT
    now = paused.transport.now
    with pytest.raises(RequestError, match="is not from 0 to"):
        paused.ask({"do": "back", "time": now + 1.0})
    paused.ask({"do": "back", "time": now / 2})
    paused.thread.join(10.0)
    (error,) = paused.ended
    assert str(error) == f"back to {now / 2:.2f} s"


@pytest.mark.parametrize("name", ["pause", "break", "back"])
def test_refused_request_gives_its_reason(name: str) -> None:
    with pytest.raises(RequestError, match=f"{name}: the robot is driven"):
        Requests(Transport(), refused={name: "the robot is driven"})({"do": name})
