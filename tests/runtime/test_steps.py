"""Steps of programs that run: exits for controllers that have arrived or are stuck."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.checking.program import check_program
from tests.runtime.conftest import Play

PROGRAM = """\
cbdsl: 1
kind: program
name: far
robot: dexter
controllers:
  home: {{potential: spring, reference: right_arm.ready, feedback: right_arm, effector: right_arm}}
  reach:
    potential: spring
    reference: {goal}
    feedback: right_arm.position
    effector: right_arm
    quiescence: {{rate: 1e-3, window: 0.3 s}}
steps:
  home: {{then: reach}}
  reach: {{{exits}}}
"""
NEAR = "[75 cm, -30 cm, 10 cm]"
FAR = "[250 cm, 0 cm, 0 cm]"


@pytest.mark.parametrize(
    ("goal", "exits", "outcome", "words"),
    [
        (NEAR, "then: home, exits: [reach arrived: succeed]", "success", "reach came to rest"),
        (
            NEAR,
            "exits: [reach stuck: fail, reach at rest: succeed]",
            "success",
            "",
        ),
        (FAR, "then: home", "failure", "reach is stuck"),
        (FAR, "exits: [reach stuck: fail the goal is too far], then: home", "failure", "too far"),
        (FAR, "exits: [reach at rest: fail both], then: home", "failure", "both"),
    ],
)
def test_exits_tell_a_controller_that_has_arrived_from_one_that_is_stuck(
    tmp_path: Path, play: Play, goal: str, exits: str, outcome: str, words: str
) -> None:
    path = tmp_path / "far.yaml"
    path.write_text(PROGRAM.format(goal=goal, exits=exits), encoding="utf-8")
    played = play(check_program(path))
    assert played.result.outcome == outcome
    assert words in played.result.ending


def test_condition_of_a_step_decides_while_the_step_runs(tmp_path: Path, play: Play) -> None:
    path = tmp_path / "far.yaml"
    conditions = "conditions: {high: right_arm.position.z > $height}\nparameters: {height: 30 cm}\n"
    text = PROGRAM.format(goal="[75 cm, -30 cm, 40 cm]", exits="exits: [high: succeed]")
    path.write_text(text + conditions, encoding="utf-8")
    played = play(check_program(path))
    assert played.result.outcome == "success"
    assert {state[2] for state in played.result.predicates if state[1] == "X"} == {"X"}
    assert played.result.predicates[-1] == "X01"
