"""``fetch`` chooses the hands by seen sizes, and puts heavy objects back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cbdsl import load, simulate
from cbdsl.program.transition import Transition

HEAVY = """
cbdsl: 1
kind: stage
name: heavy_can
description: A can of 3 kg stands to the right of a green pad.
robot: dexter

fixtures:
  table:
    form: {shape: box, size: [60 cm, 120 cm, 4 cm]}
    position: [60 cm, 0 cm, -44 cm]
    friction: 0.8
  pad:
    form: {shape: box, size: [8 cm, 8 cm, 2 mm]}
    position: [58 cm, -2 cm, -41.9 cm]
    color: [0, 0.8, 0]
    friction: 0.8

things:
  can:
    form: {shape: cylinder, radius: 3.7 cm, height: 11 cm}
    mass: 3 kg
    friction: FRICTION
    color: [1, 0, 0]

contexts:
  can:
    placed: {can: {things: [can], place: {on: table, x: [48 cm, 56 cm], y: [-24 cm, -18 cm]}}}
    joints: {pan: -0.3 rad, tilt: 1.15 rad}
"""


@pytest.mark.parametrize(("friction", "seed"), [("0.5", 7), ("0.8", 8)])
def test_fetch_of_a_can_of_3_kg_puts_it_back_after_the_first_lift(
    friction: str, seed: int, tmp_path: Path
) -> None:
    stage = tmp_path / "heavy_can.yaml"
    stage.write_text(HEAVY.replace("FRICTION", friction), "utf-8")
    with simulate(load("fetch", stage=stage), backend="mujoco", cameras="ideal") as simulated:
        truth, track, fingers = simulated.truth, [], []

        def note(_: object) -> None:
            if "can" in truth.objects:
                track.append(truth.position("can"))
                fingers.append(len(truth.touching("can")))

        result = simulated.robot.run(seed, context="can", on_tick=note)
        upright = truth.rotation("can")[2, 2]
    assert result.outcome == "failure" and "too heavy for the hand" in result.ending
    assert max(fingers) == 3 and fingers[-1] == 0
    assert np.linalg.norm(track[-1] - track[0]) < 0.02
    assert upright > 0.99


@pytest.mark.parametrize(
    ("stage", "context", "way"),
    [
        ("tall_objects", "wine_bottle", "from_side"),
        ("tall_objects", "milk", "from_side"),
        ("everyday_objects", "soup_can", "firmly"),
        ("everyday_objects", "tennis_ball", "gently"),
    ],
)
def test_fetch_takes_objects_for_one_hand_by_their_size(stage: str, context: str, way: str) -> None:
    chosen: list[str] = []

    def note(transition: Transition) -> None:
        if transition.action in ("from_side", "firmly", "gently"):
            chosen.append(transition.action)
            raise InterruptedError

    request = load("fetch", stage=stage)
    with (
        simulate(request, backend="mujoco", cameras="ideal") as simulated,
        pytest.raises(InterruptedError),
    ):
        simulated.robot.run(3, context=context, on_transition=note)
    assert chosen == [way]
