"""In the dark, a thing is found by trying places where touch was felt before."""

from __future__ import annotations

import pytest

from cbdsl.api.simulation.simulation_fixture import simulation_fixture


@pytest.mark.slow
def test_an_unseen_object_is_touched() -> None:
    succeeded, touched = [], []
    with simulation_fixture("find_by_touch", None, None, "mujoco", "ideal") as lab:
        runner, truth = lab.runner(), lab.backend.truth
        for seed in range(5610001, 5610006):
            succeeded.append(runner.run(lab.stage, seed, "dark").outcome == "success")
            things = set(truth.names()).intersection(lab.stage.things)
            touched.append(any(map(truth.touched, things)))
    # One in twelve is not found; there are no false reports.
    assert sum(succeeded) >= 4
    assert all(there for there, said in zip(touched, succeeded, strict=True) if said)


@pytest.mark.slow
def test_visual_search_in_the_dark_is_unrewarded() -> None:
    with simulation_fixture("reachtouch", None, "lights_out", "mujoco", "ideal") as lab:
        runner = lab.runner()
        lit, dark = (runner.run(lab.stage, 5610006, name).rewarded for name in ("light", "dark"))
    assert lit and not dark
