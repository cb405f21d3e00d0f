"""Programs that place an object look whether it rests where they claim to have placed it."""

from __future__ import annotations

import re
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
    form: {shape: box, size: [20 cm, 36 cm, 2 mm]}
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


#: Looks with which programs end.
_ENDS = {("deliver", "there"), ("bring_from_side", "there"), ("bring_with_both", "there")}


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

    assert rests(cbdsl.load(program, stage=stage)) is placed


#: For each program and look: values of its parameters, and distances of which it accepts one, cm.
_LOOKS: dict[tuple[str, str], tuple[dict[str, str], int, int]] = {
    ("bring", "there"): ({}, 3, 7),
    ("bring_pinched", "there"): ({}, 2, 6),
    ("build_on", "above"): ({"feature": "red", "base": "green"}, 5, 11),
    ("ensure_stacked", "above"): ({"feature": "red", "goal": "green"}, 5, 16),
    ("impedance", "inside"): ({"feature": "red", "goal": "green"}, 1, 4),
    ("stack", "on_top"): ({"feature": "red", "goal": "green", "rise": "5 cm"}, 3, 9),
    ("stand", "above"): ({"feature": "red", "goal": "green", "rise": "5 cm"}, 3, 9),
    ("stand_three", "above"): ({"goal": "green", "feature": "red"}, 5, 11),
    ("study", "above"): ({"feature": "red", "goal": "green", "rise": "5 cm"}, 3, 9),
}


_CONTROLLER = re.compile(r"^  (\w+):(.*\n(?:    .*\n)*)", re.M)
_LOOKS_AT_TWO = re.compile(r"seen_(?:above|at)\(|feedback: stereo\S*\.to\.")


def test_every_look_of_a_program_at_two_objects_is_judged() -> None:
    found = {
        (file.stem, name)
        for file in PROGRAMS.glob("*.yaml")
        for name, body in _CONTROLLER.findall(file.read_text("utf-8"))
        if _LOOKS_AT_TWO.search(body)
    }
    assert found == {*_LOOKS, *_ENDS}


@pytest.mark.parametrize("is_near", [True, False])
@pytest.mark.parametrize(("name", "look"), _LOOKS)
def test_look_accepts_objects_that_are_near_each_other_alone(
    name: str, look: str, is_near: bool, tmp_path: Path
) -> None:
    """Run the look of a program by itself."""
    values, near, far = _LOOKS[name, look]
    program, stage = tmp_path / f"{name}.yaml", tmp_path / "can_beside_a_pad.yaml"
    text = (PROGRAMS / f"{name}.yaml").read_text("utf-8")
    # Two steps with the same members would be one.
    step, more = ("judged", f"  judged: {{do: {look}, then: succeed}}\n")
    if f"\n  {look}: {{then:" in text:
        step, more = look, ""
    program.write_text(text.replace("\nsteps:\n", f"\nstart: {step}\nsteps:\n{more}"), "utf-8")
    stage.write_text(STAGE.replace("WHERE", f"{near if is_near else far} cm"), "utf-8")
    assert rests(cbdsl.load(program, values=values, stage=stage)) is is_near


def rests(request: cbdsl.RunRequest) -> bool:
    """Return whether a program succeeds as soon as it has looked."""

    def note(tick: Tick) -> None:
        if tick.observation.time > _LOOK:
            raise InterruptedError

    with cbdsl.simulate(request, backend="kinematic", cameras="ideal") as simulated:
        try:
            result = simulated.robot.run(3, on_tick=note)
        except InterruptedError:
            return False
    assert result.outcome == "success", result.ending
    return True
