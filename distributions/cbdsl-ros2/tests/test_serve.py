"""Serving: the real-time factor of a simulated robot."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.diagnostics.errors import UsageError
from cbdsl_ros2.serve import Pace, serve_robot

PERIOD = 0.01


def served(ticks: list[float]) -> tuple[str, list[str]]:
    """Return the summary, and the reports, of ticks that take so long, s."""
    time, lines = [0.0], list[str]()
    pace = Pace(PERIOD, lines.append, lambda: time[0])
    for tick in ticks:
        time[0] += tick
        assert pace.note()
    return pace.summary, lines


def test_pace_of_a_slow_simulation_is_reported_once() -> None:
    summary, lines = served([2 * PERIOD] * 2000)
    assert len(lines) == 1
    assert "real-time factor 0.50 for 5 s" in lines[0]
    assert summary == "served 20.0 s; real-time factor 0.500"


@given(st.integers(0, 3000), st.floats(0.98, 1.02))
def test_pace_of_a_real_time_simulation_is_not_reported(ticks: int, slowness: float) -> None:
    _, lines = served([slowness * PERIOD] * ticks)
    assert not lines


@pytest.mark.parametrize("pause", [1.0, 4.0])
def test_pace_notices_a_pause(pause: float) -> None:
    _, lines = served([PERIOD] * 700 + [pause] + [PERIOD] * 700)
    assert len(lines) == 1


@pytest.mark.parametrize(("place", "words"), [(".", "a folder"), ("none/a.npz", "no folder")])
def test_trace_that_cannot_be_written_is_refused_before_the_robot_is_read(
    place: str, words: str, tmp_path: Path
) -> None:
    with pytest.raises(UsageError, match=words):
        serve_robot("no robot of this name", trace=tmp_path / place)
