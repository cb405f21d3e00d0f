"""Values of parameters in texts: minus a negative quantity has no sign."""

from __future__ import annotations

import pytest

from cbdsl.checking.program import check_program
from cbdsl.program.controller import Literal, Relative
from cbdsl.yaml_text.library import Library


@pytest.mark.parametrize(("side", "sign"), [("10 cm", 1), ("-10 cm", -1)])
def test_negated_parameter_may_be_negative(
    side: str, sign: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    file = tmp_path_factory.mktemp("scope") / "sides.yaml"
    file.write_text(
        """
cbdsl: 1
kind: program
name: sides
robot: dexter
parameters: {side: 10 cm}
controllers:
  away:
    potential: spring
    reference: [30 cm, -$side, $side]
    feedback: right_arm.position
    effector: right_arm.position
  beside:
    potential: spring
    reference: "here + [0 cm, -$side, $side]"
    feedback: right_arm.position
    effector: right_arm.position
  down:
    potential: spring
    reference: -$side
    axes: [z]
    feedback: right_arm.position
    effector: right_arm.position
actions: [away, beside, down]
""",
        encoding="utf-8",
    )
    program = check_program(str(file), {"side": side}, Library(file.parent))
    references = {name: each.lead.reference for name, each in program.primitives.items()}
    assert references["away"] == Literal((0.3, -0.1 * sign, 0.1 * sign))
    assert references["beside"] == Relative(None, (0.0, -0.1 * sign, 0.1 * sign))
    assert references["down"] == Literal((0.0, 0.0, -0.1 * sign))
