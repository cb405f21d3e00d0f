"""Arrays of table and plan that grow while controllers act are never used as they were before."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cbdsl.program.checked import CheckedProgram
from cbdsl.runtime.controllers.controller_run import ControllerRun
from cbdsl.runtime.tick import Tick
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.table.reading import Reading
from tests.conftest import Checked
from tests.runtime.conftest import Play

TIMES = 1000
CHANGES = 8  # of rows, after each tick


@pytest.mark.parametrize("name", ["reachtouch", "bimanualgrab"])
def test_running_controllers_never_use_stale_arrays(
    name: str, checked: Checked, play: Play
) -> None:
    """Controllers that act go on as if nothing had been bound beside them."""
    program = checked(name)
    rng, bound, versions = np.random.default_rng(5), list[int](), set[int]()
    changes = 0

    def change(tick: Tick) -> None:
        nonlocal changes
        for _ in range(CHANGES):
            if bound and rng.random() < 0.45:
                tick.signals.release(bound.pop(int(rng.integers(len(bound)))))
            else:
                bound.append(tick.signals.bind_written(int(rng.integers(1, 40))))
                fill(tick.signals, bound[-1])
            changes += 1
        versions.add(tick.signals.table.version)

    assert_same(play, program, change)
    assert changes >= TIMES
    assert len(versions) > 3


def fill(signals: Signals, row: int) -> None:
    """Write numbers that would be noticed anywhere else."""
    rows = signals.table.rows(row)
    signals.table.write(row, Reading(np.full(len(rows), 1e3), np.full(rows.shape, 1e3), 0))


def test_controllers_may_get_slots_while_others_act(checked: Checked, play: Play) -> None:
    program, others = checked("reachtouch"), checked("bimanualgrab").primitives["squeeze"]
    added = []

    def add(tick: Tick) -> None:
        plan: Any = tick.run.runs[0]._plan
        more = others.controllers if len(added) < 100 else ()
        added.extend(ControllerRun(each, tick.signals, plan, 0.01) for each in more)

    assert_same(play, program, add)
    assert len(added) == 100


def assert_same(play: Play, program: CheckedProgram, watch: Callable[[Tick], None]) -> None:
    """Assert that an episode has the same references with and without a listener."""
    alone, beside = (
        play(program, joints={"pan": 0.9}),
        play(program, joints={"pan": 0.9}, watch=watch),
    )
    assert np.ptp(alone.backend.applied, axis=0).max() > 0.5
    np.testing.assert_array_equal(beside.backend.applied, alone.backend.applied)
    assert beside.transitions == alone.transitions
