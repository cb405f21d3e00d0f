"""Stop watch: buttons that press, repeat, fall silent and end."""

from __future__ import annotations

import pytest

from cbdsl.extend.driver import PublishersSample, StopSample
from cbdsl_drive.stop_watch import StopWatch
from tests.driven_robot import robot

REPEATS = {"stop": "/stop", "stop_deadline": "250 ms"}
CHANGES = {"stop": "/stop", "stop_repeats": False}
TWO = PublishersSample("arm", {1: "process 11", 2: "process 22"})


def released(source: int) -> StopSample:
    return StopSample("arm", False, source)


@pytest.mark.parametrize("driver", [REPEATS, CHANGES])
def test_stop_watch_knows_the_state_once_each_button_has_sent_it(driver: dict[str, object]) -> None:
    stops = StopWatch(robot(**driver))
    assert [address for address, _ in stops.unheard()] == ["/stop"]
    stops.note_publishers(TWO, 0.0)
    stops.note(released(1), 0.1)
    assert not list(stops.unheard())
    (unknown,) = stops.unsure(0.1)
    assert unknown.startswith("the emergency stop of driver 'arm' (process 22) has sent no state")
    stops.note(released(2), 0.1)
    assert not list(stops.unsure(0.1))


@pytest.mark.parametrize(("driver", "found"), [(REPEATS, True), (CHANGES, False)])
def test_stop_watch_finds_a_button_that_falls_silent(
    driver: dict[str, object], found: bool
) -> None:
    stops = StopWatch(robot(**driver))
    stops.note_publishers(TWO, 0.0)
    for tick in range(20):
        stops.note(released(1), 0.1 * tick)
        if tick < 10:
            stops.note(released(2), 0.1 * tick)
        silent = list(stops.unsure(0.1 * tick, moves=True))
        assert bool(silent) is (found and tick >= 12), tick
    assert silent == found * [
        "the emergency stop of driver 'arm' (process 22) is silent for 1000 ms "
        "(stop_deadline 250 ms)"
    ]


@pytest.mark.parametrize(("driver", "found"), [(REPEATS, True), (CHANGES, False)])
def test_stop_watch_finds_a_button_that_ends(driver: dict[str, object], found: bool) -> None:
    stops = StopWatch(robot(**driver))
    stops.note_publishers(TWO, 0.0)
    stops.note(released(2), 0.0)
    stops.note(released(1), 0.0)
    ended = stops.note_publishers(PublishersSample("arm", {1: "process 11"}), 0.1)
    assert ended == found * "an emergency stop of driver 'arm' has ended (process 22)"
    stops.note(released(1), 10.0)
    assert not list(stops.unsure(10.0)), "an ended button has no deadline"


@pytest.mark.parametrize(("driver", "first"), [(REPEATS, 0.25), (CHANGES, 1.0)])
def test_stop_watch_gives_a_new_button_time_for_its_first_message(
    driver: dict[str, object], first: float
) -> None:
    stops = StopWatch(robot(**driver))
    stops.note_publishers(PublishersSample("arm", {1: "process 11"}), 5.0)
    assert list(stops.unsure(5.0))
    assert not list(stops.unsure(5.0 + 0.9 * first, moves=True))
    assert list(stops.unsure(5.0 + 1.1 * first, moves=True))


def test_stop_watch_keeps_the_press_of_a_button_that_ended() -> None:
    stops = StopWatch(robot(**REPEATS))
    stops.note_publishers(TWO, 0.0)
    assert stops.note(StopSample("arm", True, 2), 0.0)
    stops.note_publishers(PublishersSample("arm", {1: "process 11"}), 0.1)
    stops.note(released(1), 0.1)
    assert stops.pressed() == ["arm"]
