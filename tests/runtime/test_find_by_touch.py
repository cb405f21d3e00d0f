"""In the dark, a thing is found by trying places where touch was felt before."""

from __future__ import annotations

import pytest

from cbdsl.reproduction.simulation_fixture import simulation_fixture


@pytest.mark.slow
def test_a_thing_is_touched_that_nobody_sees() -> None:
    found = []
    with simulation_fixture("find_by_touch", None, None, "mujoco", "ideal") as lab:
        runner, truth = lab.runner(), lab.backend.truth
        for seed in (7610001, 7610006, 7610010):
            result = runner.run(lab.stage, seed, "dark")
            things = set(truth.names()).intersection(lab.stage.things)
            found.append(result.outcome == "success" and any(map(truth.touched, things)))
    assert found == [True] * 3


@pytest.mark.slow
def test_who_looks_for_it_does_not_find_it_in_the_dark() -> None:
    with simulation_fixture("reachtouch", None, "lights_out", "mujoco", "ideal") as lab:
        runner = lab.runner()
        lit, dark = (runner.run(lab.stage, 7610006, name).rewarded for name in ("light", "dark"))
    assert lit and not dark
