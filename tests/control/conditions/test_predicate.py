"""The quiescence predicate: windows by time, images slower than ticks, and resets."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.control.conditions.predicate import (
    PREDICATE,
    PREDICATES,
    ROOM,
    Predicate,
    note,
    note_undefined,
    require_settled,
    reset,
    restart,
    room_of,
    settings_of,
)

TICK = 1 / 120
IMAGE = 8  # ticks per image at 15 Hz


class Monitor:
    """Entries of one potential in a slot of the plan."""

    def __init__(self, rate: float, window: float, period: float) -> None:
        self.settings = settings_of(rate, window, period)
        self.window = np.zeros(room_of(self.settings))
        self.notes = np.zeros(6, dtype=np.int64)
        self.notes[ROOM] = len(self.window)
        reset(self.notes)

    def update(self, phi: float, stamp: int, ripple: float = 0.0) -> str:
        note(phi, ripple, stamp, self.settings, self.window, self.notes)
        return self.predicate

    @property
    def predicate(self) -> str:
        return str(PREDICATES[self.notes[PREDICATE]])


def watch(monitor: Monitor, values: Sequence[float], fresh: Callable[[int], bool]) -> str:
    """Return states for values in ticks, some of which bring a measurement with its own stamp."""
    stamps = np.cumsum([fresh(tick) for tick, _ in enumerate(values)])
    return "".join(
        monitor.update(phi, int(stamp)) for phi, stamp in zip(values, stamps, strict=True)
    )


def every_tick(tick: int) -> bool:
    return True


def every_image(tick: int) -> bool:
    return tick % IMAGE == 0


def test_predicates_are_joined_to_a_state() -> None:
    assert "".join(Predicate) == "X-01"


def test_rest_needs_a_full_window() -> None:
    monitor = Monitor(rate=1e-4, window=0.25, period=TICK)
    assert watch(monitor, [2.0] * 40, every_tick) == "0" * 30 + "1" * 10


@given(slope=st.floats(0.01, 100), excess=st.sampled_from([0.9, 1.1]))
def test_rest_threshold_is_a_rate_independent_of_the_period(slope: float, excess: float) -> None:
    monitor = Monitor(rate=slope / excess, window=0.25, period=TICK)
    ramp = [10 - slope * tick * TICK for tick in range(60)]
    assert watch(monitor, ramp, every_tick)[-20:] == ("1" if excess < 1 else "0") * 20


def test_decaying_potential_comes_to_rest_once() -> None:
    monitor = Monitor(rate=1e-3, window=0.3, period=TICK)
    states = watch(monitor, [math.exp(-4 * tick * TICK) for tick in range(600)], every_tick)
    assert states.strip("1").strip("0") == ""
    assert states.endswith("1")


def test_restarted_monitor_rests_only_after_another_window() -> None:
    monitor = Monitor(rate=1e-4, window=0.25, period=TICK)
    watch(monitor, [2.0] * 40, every_tick)
    restart(monitor.notes)
    assert monitor.predicate == "0"
    assert watch(monitor, [2.0] * 40, every_tick) == "0" * 30 + "1" * 10


def test_restart_of_an_undefined_monitor_keeps_it_undefined() -> None:
    monitor = Monitor(rate=1e-4, window=0.25, period=TICK)
    note_undefined(monitor.notes)
    restart(monitor.notes)
    assert monitor.predicate == "-"


def test_disturbance_ends_the_rest() -> None:
    monitor = Monitor(rate=1e-3, window=0.1, period=TICK)
    states = watch(monitor, [0.0] * 20 + [0.5] * 20, every_tick)
    assert states[19] == "1"
    assert states[20:32] == "0" * 12
    assert states[-1] == "1"


def test_potential_repeated_between_images_is_not_at_rest() -> None:
    """Lower the potential with every image; between images it only looks constant."""
    window = 0.05  # shorter than the 66.7 ms between two images
    falling = [1.0 / (1 + tick // IMAGE) for tick in range(IMAGE * 12)]
    assert "1" in watch(Monitor(1e-3, window, TICK), falling, every_tick)
    assert "1" not in watch(Monitor(1e-3, window, TICK), falling, every_image)


def test_rest_over_images_is_counted_in_time() -> None:
    window = 0.2  # three images
    states = watch(Monitor(1e-3, window, TICK), [0.3] * (IMAGE * 6), every_image)
    assert states == "0" * (3 * IMAGE) + "1" * (3 * IMAGE)


def test_undefined_value_clears_the_history_and_reads_undefined() -> None:
    monitor = Monitor(rate=1e-3, window=0.1, period=TICK)
    assert watch(monitor, [0.0] * 20, every_tick)[-1] == "1"
    note_undefined(monitor.notes)
    assert monitor.predicate == Predicate.UNDEFINED
    assert watch(monitor, [0.0] * 13, every_tick) == "0" * 12 + "1"


def test_reset_clears_the_history_of_a_monitor() -> None:
    monitor = Monitor(rate=1e-3, window=0.1, period=TICK)
    watch(monitor, [0.0] * 20, every_tick)
    reset(monitor.notes)
    assert monitor.predicate == Predicate.INACTIVE
    assert monitor.update(0.0, -1) == Predicate.TRANSIENT  # nothing was measured
    assert watch(monitor, [0.0] * 13, every_tick) == "0" * 12 + "1"


@pytest.mark.parametrize(("rate", "window"), [(0, 1), (1, 0), (-1, 1), (math.nan, 1)])
def test_rate_and_window_are_positive(rate: float, window: float) -> None:
    with pytest.raises(ValueError, match="positive"):
        Monitor(rate, window, TICK)


@pytest.mark.parametrize(
    ("error", "bound", "predicate"),
    [(0.1, math.inf, "1"), (0.1, 0.1, "1"), (0.1001, 0.1, "0"), (math.nan, 0.1, "0")],
)
def test_require_settled_beyond_the_bound_reads_as_transient(
    error: float, bound: float, predicate: str
) -> None:
    monitor = Monitor(1.0, 5 * TICK, TICK)
    assert watch(monitor, [0.3] * 20, every_tick)[-1] == "1"
    require_settled(error, bound, monitor.notes)
    assert monitor.predicate == predicate


def test_require_settled_leaves_an_undefined_potential_undefined() -> None:
    monitor = Monitor(1.0, 5 * TICK, TICK)
    note_undefined(monitor.notes)
    require_settled(1.0, 0.1, monitor.notes)
    assert monitor.predicate == "-"


@pytest.mark.parametrize(("ripple", "rests"), [(0.9e-3, False), (1.1e-3, True)])
def test_potential_that_flips_by_the_ripple_of_its_encoders_is_at_rest(
    ripple: float, rests: bool
) -> None:
    monitor = Monitor(rate=1e-6, window=0.1, period=TICK)
    seen = [monitor.update(0.1 + 1e-3 * (tick % 2), tick, ripple) for tick in range(30)]
    assert (seen[-1] == "1") is rests
