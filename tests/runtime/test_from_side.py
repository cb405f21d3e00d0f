"""Grasps from the side: refusals before motion, and a bottle that is carried upright."""

from __future__ import annotations

import numpy as np
import pytest

import cbdsl
from cbdsl.runtime.tick import Tick

# Largest angle between the palm's normal and the level, and between the bottle's axis and the
# vertical, while a hand holds it; largest turn of an arm that does not move, rad.
_LEVEL, _UPRIGHT, _STILL = np.radians(6.0), np.radians(8.0), 0.02


@pytest.mark.parametrize(
    ("context", "values", "reason"),
    [
        ("soup_can", {}, "too low for a grasp from the side"),
        ("carton", {"deep": "10 cm"}, "too deep for a grasp from the side"),
        ("parcel", {}, "wider than the hand"),
    ],
)
def test_take_from_side_of_an_unfit_object_names_the_reason_and_moves_no_arm(
    context: str, values: dict[str, str], reason: str
) -> None:
    postures: list[np.ndarray] = []

    def note(tick: Tick) -> None:
        postures.append(tick.observation.positions[tick.signals.joints.of("right_arm")])

    program = cbdsl.load("take_from_side", stage="everyday_objects", values=values)
    with cbdsl.simulate(program, backend="kinematic") as fixture:
        result = fixture.robot.run(61_000, context=context, on_tick=note)
    assert result.outcome == "failure" and reason in result.ending
    assert np.ptp(postures, axis=0).max() < _STILL


def test_bring_from_side_carries_a_bottle_upright_with_a_level_palm() -> None:
    tilts, slopes = [], []
    with cbdsl.simulate("bring_from_side", backend="mujoco", cameras="ideal") as fixture:
        truth = fixture.truth

        def note(_: Tick) -> None:
            if truth.is_touched("wine_bottle"):
                tilts.append(np.arccos(min(1.0, truth.rotation("wine_bottle")[2, 2])))
                slopes.append(abs(np.arcsin(truth.link_rotation("right_palm")[2, 2])))

        result = fixture.robot.run(61_000, context="wine_bottle", on_tick=note)
        away = truth.position("wine_bottle")[:2] - truth.position("pad")[:2]
    assert result.outcome == "success", result.ending
    assert tilts and max(tilts) < _UPRIGHT and max(slopes) < _LEVEL
    assert np.linalg.norm(away) < 0.04
