"""Simulation: missing packages, and compilation of the control tick in a second process."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from cbdsl.backends.engines import extra_advice
from cbdsl.cli.episodes.simulation import needing_simulation
from cbdsl.diagnostics.errors import UsageError

RUN = """
import sys
from cbdsl.api.requests.load_request import LoadOptions
from cbdsl.cli.episodes.simulation import simulation
from cbdsl.control.compiled_tick import tick
from cbdsl.runtime.episode import Runner
request = LoadOptions().read("searchtrack")
with simulation(request, "kinematic") as (backend, kinematics):
    next(Runner(request.robot, kinematics, request.program, backend).ticks(request.stage, 0))
print(sum(tick.stats.cache_hits.values()), sum(tick.stats.cache_misses.values()))
"""


@pytest.mark.parametrize(
    ("module", "extra"),
    [("cyclonedds", "ros2"), ("cyclonedds.core", "ros2"), ("pinocchio", "sim"), ("mujoco", "sim")],
)
def test_missing_package_is_reported_with_its_extra(module: str, extra: str) -> None:
    with pytest.raises(UsageError) as raised, needing_simulation():
        raise ModuleNotFoundError(f"No module named '{module}'", name=module)
    expected = f"running needs {module}, which is not installed: {extra_advice(extra)}"
    assert str(raised.value) == expected


@pytest.mark.slow
@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="one core compiles alone")
def test_another_process_compiles_the_tick_of_a_first_run(tmp_path: Path) -> None:
    surroundings = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "kept")}
    done = subprocess.run(
        [sys.executable, "-c", RUN], env=surroundings, capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["1", "0"]
