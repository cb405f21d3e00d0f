"""Conditions of programs: types, units and names of their comparisons."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.program import check_program
from cbdsl.checking.rules.flow import automaton_of
from cbdsl.diagnostics.errors import DiagnosticsError

PROGRAM = """\
cbdsl: 1
kind: program
name: rise
robot: dexter
parameters: {{least: 20 cm}}
controllers:
  rise:
    potential: spring
    reference: "here + [0 cm, 0 cm, 20 cm]"
    feedback: right_arm.position
    effector: right_arm
conditions:
  high: {condition}
{rest}
"""
STEPS = "steps:\n  rise: {exits: [high: succeed, not high and rise at rest: fail it is low]}"
LEARNED = "actions: [rise]\npolicy: {'*0': rise}"


def written(folder: Path, condition: str, rest: str = STEPS) -> Path:
    path = folder / "rise.yaml"
    path.write_text(PROGRAM.format(condition=condition, rest=rest), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("condition", "code", "column", "words"),
    [
        ("right_arm.position.z > 20 N", "CB658", 32, "'20 N' has the dimension force"),
        (
            "right_arm.position > 20 cm",
            "CB658",
            9,
            "a component, as 'right_arm.position.z'",
        ),
        ("right_arm.position.z > right_hand.net.force.z", "CB658", 32, "is a force in N"),
        ("right_hand.x > 20 deg", "CB658", 9, "has no component along x"),
        ("head.uniform > 20 deg", "CB658", 9, "'head.uniform' is random"),
        ("right_arm.position.z > 2 cm for 3 cm", "CB658", 41, "has the dimension length"),
        ("3 cm > 2 cm", "CB658", 9, "no signal"),
        ("right_arm.positon.z > 20 cm", "CB501", 9, "'right_arm.positon'"),
        ("right_arm.position.z > $leat", "CB402", 32, "'leat'"),
        ("right_arm.position.z >", "CB657", 31, "expected a signal or a quantity"),
    ],
)
def test_condition_with_a_fault_is_one_error_at_its_place(
    tmp_path: Path, condition: str, code: str, column: int, words: str
) -> None:
    with pytest.raises(DiagnosticsError) as raised:
        check_program(written(tmp_path, condition))
    errors = [each for each in raised.value.diagnostics if each.is_error]
    assert [(each.code, each.place.column) for each in errors] == [(code, column)]
    assert words in errors[0].message


def test_exits_have_conditions_as_members_behind_all_others(tmp_path: Path) -> None:
    program = check_program(written(tmp_path, "right_arm.position.z > $least for 0.3 s"))
    assert program.members == ("rise", "high")
    assert program.conditions["high"].text == "right_arm.position.z > 20 cm for 0.3 s"
    assert [action.conditions for action in program.actions] == [("high",)]
    automaton = automaton_of(program)
    assert automaton is not None and automaton.steps["rise"].values[1] == "01"


def test_program_without_steps_has_each_condition_as_a_letter(tmp_path: Path) -> None:
    program = check_program(written(tmp_path, "right_arm.position.z > $least", LEARNED))
    assert program.members == ("rise", "high")
    assert program.actions[0].conditions == ("high",)


@pytest.mark.parametrize(
    ("exits", "is_certain"),
    [
        ("[first undefined: second, near: end]", True),
        ("[near: end, first undefined: second]", False),
    ],
)
def test_cycle_of_undefined_steps_is_certain_for_all_values_of_conditions(
    tmp_path: Path, exits: str, is_certain: bool
) -> None:
    track = (
        "{potential: spring, reference: [0 deg, 0 deg], feedback: cyclopean.red, effector: head}"
    )
    path = tmp_path / "look.yaml"
    path.write_text(
        "cbdsl: 1\nkind: program\nname: look\nrobot: dexter\n"
        f"controllers: {{first: {track}, second: {track}}}\n"
        "conditions: {near: stereo.red.x < 60 cm}\n"
        f"steps:\n  first: {{exits: {exits}}}\n  second: {{then: end, failed: first}}\n",
        encoding="utf-8",
    )
    codes = [each.code for each in check_document(path)]
    assert ("CB727" in codes) == is_certain and set(codes) <= {"CB727"}
