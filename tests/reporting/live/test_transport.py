"""The transport: real time, pauses, single ticks, and requests between ticks."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, Thread

import pytest

from cbdsl.reporting.live import transport as module
from cbdsl.reporting.live.transport import IdleError, Transport

LONG = 20.0


class World:
    """Loop of 50 ms ticks that the transport holds."""

    def __init__(self, transport: Transport) -> None:
        self.ticks = self.shown = 0
        self._transport = transport
        self._over = False

    def run(self) -> None:
        while not self._over:
            self._transport.hold(0.05 * self.ticks, self._show)
            self.ticks += 1

    def end(self) -> None:
        self._over = True
        self._transport.release()

    def _show(self) -> None:
        self.shown += 1


@contextmanager
def running(transport: Transport) -> Iterator[World]:
    world = World(transport)
    thread = Thread(target=world.run)
    thread.start()
    try:
        yield world
    finally:
        world.end()
        thread.join(LONG)
        assert not thread.is_alive()


def until(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + LONG
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.005)


@pytest.mark.parametrize("speed", [1.0, 4.0])
def test_simulated_time_does_not_run_ahead_of_the_wall(speed: float) -> None:
    transport, began = Transport(speed), time.perf_counter()
    transport.begin()
    for tick in range(9):
        transport.hold(0.05 * tick, lambda: None)
        assert time.perf_counter() - began >= 0.05 * tick / speed


def test_world_that_fell_behind_does_not_hurry() -> None:
    now = [0.0]
    transport = Transport(1.0, lambda: now[0])
    transport.hold(0.0, lambda: None)
    now[0] = 100.0
    transport.hold(1.0, lambda: None)
    assert transport._pause_at(1.5) == pytest.approx(0.5)


def test_fast_run_is_never_delayed() -> None:
    now = [5.0]
    transport = Transport(math.inf, lambda: now[0])
    for tick in range(1000):
        transport.hold(100.0 * tick, lambda: None)
    assert transport.shown_speed is None


def test_pausing_stops_ticks_and_a_step_lets_exactly_one_pass() -> None:
    transport = Transport(math.inf)
    transport.pause()
    with running(transport) as world:
        until(lambda: world.shown > 0)
        assert (world.ticks, transport.paused) == (0, True)
        for count in (1, 2):
            transport.step()
            until(lambda count=count: world.ticks == count)
            shown = world.shown
            until(lambda shown=shown: world.shown >= shown)
            assert transport.paused
        transport.step(10)
        until(lambda: world.ticks == 12)
        transport.ask(lambda: None)
        assert world.ticks == 12
        transport.go_on()
        until(lambda: world.ticks > 100)


def test_speed_can_be_changed_during_a_run() -> None:
    transport = Transport(0.01)
    with running(transport) as world:
        until(lambda: world.ticks == 1)
        transport.hasten(math.inf)
        until(lambda: world.ticks > 100)
    assert transport.shown_speed is None


def test_requests_are_done_between_ticks_by_the_thread_of_the_ticks() -> None:
    transport, asked = Transport(math.inf), []
    transport.pause()
    with running(transport) as world:
        until(lambda: world.shown == 1)
        assert transport.ask(lambda: asked.append(world.ticks) or "done") == "done"
        until(lambda: world.shown == 2)
        with pytest.raises(ZeroDivisionError):
            transport.ask(lambda: 1 / 0)
        transport.step()
        until(lambda: world.ticks == 1)
    assert asked == [0]


def test_request_that_no_tick_answers_is_never_done(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_PATIENCE", 0.01)
    transport, done = Transport(math.inf), Event()
    with pytest.raises(IdleError):
        transport.ask(done.set)
    transport.hold(0.0, lambda: None)
    assert not done.is_set()


@pytest.mark.parametrize("error", [None, TimeoutError("of its own"), ValueError("of its own")])
def test_request_that_a_tick_has_begun_is_answered_when_it_is_done(
    error: Exception | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Take longer for a request than a request without a tick may wait."""
    monkeypatch.setattr(module, "_PATIENCE", 0.2)
    transport, begun, go_on = Transport(math.inf), Event(), Event()
    answers: list[object] = []

    def do() -> str:
        begun.set()
        assert go_on.wait(LONG)
        if error is not None:
            raise error
        return "done"

    def ask() -> None:
        try:
            answers.append(transport.ask(do))
        except Exception as raised:
            answers.append(raised)

    page = Thread(target=ask)
    page.start()
    ticks = Thread(
        target=lambda: [transport.hold(0.0, lambda: None) for _ in iter(begun.is_set, True)]
    )
    ticks.start()
    assert begun.wait(LONG)
    page.join(0.5)
    assert not answers, "the request is neither refused nor done"
    go_on.set()
    page.join(LONG)
    ticks.join(LONG)
    assert answers == ["done" if error is None else error]


def test_released_run_cannot_be_paused() -> None:
    transport = Transport(math.inf)
    transport.release()
    transport.pause()
    transport.hold(0.0, lambda: None)
    assert not transport.paused


def test_return_passes_at_maximum_speed_and_pauses_at_its_time() -> None:
    transport = Transport(1.0)
    transport.run_to(0.5)
    with running(transport) as world:
        until(lambda: transport.paused)
        assert not transport.is_returning
        assert 0.5 <= transport.now < 0.6
        assert world.shown > 0
