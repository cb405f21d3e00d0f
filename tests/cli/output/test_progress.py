"""Progress: silent during short work, then the remaining time."""

from __future__ import annotations

import pytest

from cbdsl.cli.output import progress


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Replace the clock by a list with the time, s."""
    now = [100.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    return now


def test_short_work_prints_no_progress(
    clock: list[float], capsys: pytest.CaptureFixture[str]
) -> None:
    with progress.Progress("work") as told:
        clock[0] += 1.9
        told.note(1, 2)
    assert capsys.readouterr().err == ""


def test_long_work_prints_the_remaining_time(
    clock: list[float], capsys: pytest.CaptureFixture[str]
) -> None:
    with progress.Progress("work") as told:
        clock[0] += 30
        told.note(1, 4)
        told.note(2, 4)  # immediately after the first line
        clock[0] += 30
        told.note(3, 4)
    assert capsys.readouterr().err.splitlines() == [
        "work: 1 of 4, about 1 min 30 s left",
        "work: 3 of 4, about 0 min 20 s left",
    ]
