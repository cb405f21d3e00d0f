"""In the dark, a thing is found by trying places where touch was felt before."""

from __future__ import annotations

import pytest

import cbdsl


@pytest.mark.slow
def test_unseen_object_is_touched() -> None:
    succeeded, touched = [], []
    with cbdsl.simulate("find_by_touch", backend="mujoco", cameras="ideal") as lab:
        robot, truth = lab.robot, lab.truth
        for seed in range(5610001, 5610006):
            succeeded.append(robot.run(seed, context="dark").outcome == "success")
            things = set(truth.objects).intersection(robot.request.stage.things)
            touched.append(any(map(truth.is_touched, things)))
    # One in twelve is not found; there are no false reports.
    assert sum(succeeded) >= 4
    assert all(there for there, said in zip(touched, succeeded, strict=True) if said)


@pytest.mark.slow
def test_visual_search_in_the_dark_is_unrewarded() -> None:
    program = cbdsl.load("reachtouch", stage="lights_out")
    with cbdsl.simulate(program, backend="mujoco", cameras="ideal") as lab:
        lit, dark = (lab.robot.run(5610006, context=name).rewarded for name in ("light", "dark"))
    assert lit and not dark
