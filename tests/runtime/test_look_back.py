"""Programs that place an object look whether it rests where they claim to have placed it."""

from __future__ import annotations

from pathlib import Path

import pytest

import cbdsl
from cbdsl.runtime.tick import Tick

PROGRAMS = Path(__file__).parents[2] / "programs"

STAGE = """
cbdsl: 1
kind: stage
name: can_beside_a_pad
description: A red can stands on a green pad, or a little beside its centre.
robot: dexter

fixtures:
  table:
    form: {shape: box, size: [60 cm, 120 cm, 4 cm]}
    position: [60 cm, 0 cm, -44 cm]
  pad:
    form: {shape: box, size: [20 cm, 20 cm, 2 mm]}
    position: [60 cm, 0 cm, -41.9 cm]
    color: [0, 0.8, 0]

things:
  can: {form: {shape: cylinder, radius: 3.7 cm, height: 11 cm}, mass: 300 g, color: [1, 0, 0]}

contexts:
  can:
    placed: {can: {things: [can], place: {on: pad, x: 60 cm, y: WHERE}}}
    joints: {pan: 0 rad, tilt: 1.15 rad}
"""

#: Longest that a look takes, s.
_LOOK = 3.0


@pytest.mark.parametrize(("away", "placed"), [(0, True), (2, True), (6, False), (-8, False)])
@pytest.mark.parametrize(
    ("name", "step"),
    [("deliver", "there"), ("bring_from_side", "there"), ("bring_with_both", "settled")],
)
def test_look_back_accepts_an_object_at_its_goal_alone(
    name: str, step: str, away: int, placed: bool, tmp_path: Path
) -> None:
    """Offset a can from the pad's centre by some centimetres, and begin with the look."""
    program, stage = tmp_path / f"{name}.yaml", tmp_path / "can_beside_a_pad.yaml"
    text = (PROGRAMS / f"{name}.yaml").read_text("utf-8")
    program.write_text(text.replace("\nsteps:\n", f"\nstart: {step}\n\nsteps:\n"), "utf-8")
    stage.write_text(STAGE.replace("WHERE", f"{away} cm"), "utf-8")

    def note(tick: Tick) -> None:
        if tick.observation.time > _LOOK:
            raise InterruptedError

    with cbdsl.simulate(
        cbdsl.load(program, stage=stage), backend="kinematic", cameras="ideal"
    ) as simulated:
        try:
            result = simulated.robot.run(3, on_tick=note)
        except InterruptedError:
            assert not placed
        else:
            assert placed and result.outcome == "success", result.ending
