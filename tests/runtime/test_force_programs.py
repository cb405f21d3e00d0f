"""Programs of force and place, judged by the simulator."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.cli.run_request import read_request
from cbdsl.cli.simulation import simulation
from cbdsl.reproduction.simulation_fixture import simulation_fixture
from cbdsl.runtime.episode import Runner, Tick


@pytest.mark.slow
def test_the_force_stays_while_the_hand_slides() -> None:
    forces, places = [], []
    with simulation_fixture("press_and_slide", {"by_y": "-8 cm", "force": "4 N"}) as fixture:
        truth = fixture.backend.truth

        def note(tick: Tick) -> None:
            if tick.run.action is not None and tick.run.action.name.startswith("along"):
                forces.append(-truth.wrenches()[:, 2].sum())
                places.append(truth.link_pose("right_palm").position.copy())

        result = fixture.runner().run(fixture.stage, 3, on_tick=note)
    assert result.outcome == "success"
    means = np.convolve(forces, np.full(6, 1 / 6), mode="valid")
    # The fingertips stick before they slide, by up to 0.8 N here.
    np.testing.assert_allclose(means, 4.0, atol=1.0)
    np.testing.assert_allclose((places[-1] - places[0])[:2], [0, -0.08], atol=0.005)


@pytest.mark.slow
def test_what_is_put_down_stands_where_it_was_held() -> None:
    with simulation_fixture("take_and_put_down") as fixture:
        truth, held = fixture.backend.truth, []

        def note(tick: Tick) -> None:
            if tick.run.children["put_down"].predicate == "0" and not held:
                (thing,) = (name for name in truth.names() if name != "table")
                held.append((thing, truth.pose(thing).position.copy()))

        result = fixture.runner().run(fixture.stage, 12, on_tick=note)
        assert result.outcome == "success", result.ending
        ((thing, before),) = held
        after = truth.pose(thing).position
        assert before[2] - after[2] > 0.1
        assert np.linalg.norm((after - before)[:2]) < 0.02
        assert np.linalg.norm(truth.velocity(thing)[:3]) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("giver", ["right", "left"])
def test_a_thing_is_handed_over_in_either_direction(giver: str) -> None:
    """From hand to hand: at last the other one alone touches it, high above the table."""
    taker, side = ("left", -1) if giver == "right" else ("right", 1)
    values = {
        "arm": f"{giver}_arm", "hand": f"{giver}_hand",
        "to_arm": f"{taker}_arm", "to_hand": f"{taker}_hand",
        "side": f"{10 * side} cm", "turn": f"{-69.282 * side} deg", "away": f"{20 * side} cm",
    }  # fmt: skip
    request = read_request("handover", None, None, values)
    with simulation(request, "bullet", cameras="ideal") as (backend, kinematics):
        truth = backend.truth
        runner = Runner(request.robot, kinematics, request.program, backend)
        result = runner.run(request.stage, 8000320, f"cube_{giver}")
        assert result.outcome == "success", result.ending
        assert {hand for hand, _ in truth.touching("cube")} == {f"{taker}_hand"}
        place = truth.pose("cube").position
        assert place[2] > -0.3
        away = place - truth.link_pose(f"{giver}_palm").position
        assert np.linalg.norm(away) > 0.2
