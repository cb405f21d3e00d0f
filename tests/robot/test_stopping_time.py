"""Stopping time: bounds of a robot's document."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.robot.stopping_time import stopping_lines, stopping_time
from cbdsl.robot.urdf_reader import parse_urdf
from tests.driven_robot import URDF, robot


@pytest.mark.parametrize(
    ("rate", "driver", "death", "fault"),
    [
        # Three periods and one more; the deadline, braking from 1.5 rad/s in 50 ms, three periods.
        (60.0, {}, 66.7, 50.0 + 50.0 + 50.0),
        (250.0, {}, 16.0, 12.0 + 52.0 + 12.0),
        (20.0, {"deadline": 0.075}, 200.0, 75.0 + 50.0 + 150.0),
        (20.0, {"deadline": 0.075, "horizon": 0.08}, 130.0, 75.0 + 50.0 + 80.0),
        (60.0, {"acceleration": 100.0}, 66.7, 50.0 + 16.7 + 50.0),
        (60.0, {"form": "positions"}, 133.3, 133.3),
    ],
)
def test_stopping_time_follows_from_the_document(
    rate: float, driver: dict[str, object], death: float, fault: float
) -> None:
    document = robot(**driver)
    control = document.control.model_copy(update={"rate": rate})
    document = document.model_copy(update={"control": control})
    model = parse_urdf(URDF, Path("rail.urdf"))
    bounds = stopping_time(document, model, "arm")
    assert [1e3 * bound for bound in bounds] == pytest.approx([death, fault], abs=0.1)


def test_stopping_time_lasts_until_silent_load_cells_are_noticed() -> None:
    model, touch = parse_urdf(URDF, Path("rail.urdf")), {"wrenches": {"arm": {"tip": "/tip"}}}
    seeing, feeling = robot(deadline=0.4), robot(deadline=0.4, **touch)
    times = [stopping_time(document, model, "arm") for document in (seeing, feeling)]
    # Without joint states no reference follows, and a trajectory ends after three periods.
    assert times[1].fault - times[0].fault == pytest.approx(0.4 - 0.06)
    assert times[1].death == times[0].death


@pytest.mark.parametrize(("acceleration", "is_slow"), [(100.0, False), (5.0, True)])
def test_stopping_lines_name_late_drivers(acceleration: float, is_slow: bool) -> None:
    document, model = robot(acceleration=acceleration), parse_urdf(URDF, Path("rail.urdf"))
    (line,) = stopping_lines(document, model)
    assert line.startswith("driver 'arm' stands 80 ms after its program ends and ")
    assert line.endswith("; 150 ms are accepted (CB325)" if is_slow else "after a fault, at 50 Hz")
    assert stopping_lines(document, model, slow=True) == ([line] if is_slow else [])
