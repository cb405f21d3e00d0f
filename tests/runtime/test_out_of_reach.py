"""A robot comes to rest in front of an object beyond its reach, on engines with and without lag."""

from __future__ import annotations

import numpy as np
import pytest

import cbdsl
from cbdsl.backends.engines import installed_engines
from cbdsl.runtime.tick import Tick

#: Largest motion back and forth of a joint in the last second, rad; a swing has 0.3.
_SWING = np.deg2rad(1.0)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("engine", ["mujoco", "kinematic"])
def test_reachtouch_beyond_the_reach_ends_without_a_swing(engine: str, seed: int) -> None:
    if engine not in installed_engines():
        pytest.skip(f"{engine} is not installed")
    request = cbdsl.load("reachtouch", stage="out_of_reach")
    times: list[float] = []
    positions: list[np.ndarray] = []

    def watch(tick: Tick) -> None:
        times.append(tick.observation.time)
        positions.append(np.array(tick.observation.positions))

    (result,) = cbdsl.run(request, seed=seed, backend=engine, cameras="ideal", on_tick=watch)
    assert not result.rewarded
    rows = np.array(positions)[np.array(times) > times[-1] - 1.0]
    path = np.abs(np.diff(rows, axis=0)).sum(axis=0)
    assert (path - np.abs(rows[-1] - rows[0])).max() < _SWING
