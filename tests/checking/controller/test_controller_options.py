"""Options of a controller: the tolerance of its arrival."""

from __future__ import annotations

import math
from pathlib import Path
from textwrap import dedent

import pytest

from cbdsl.checking.program import check_program
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.yaml_text.library import Library

_RATES = "rate: 1e-4, window: 0.3 s"


def arrival(folder: Path, options: str, task: str = "", kind: str = "position") -> object:
    """Return the arrival of a controller with some options, on a robot with some of its task."""
    robot = (Path(__file__).parents[3] / "robots" / "sixaxis.yaml").read_text("utf-8")
    model = (Path(__file__).parents[3] / "robots" / "sixaxis.urdf").resolve()
    robot = robot.replace("sixaxis.urdf", str(model))
    robot = robot.replace("acceleration: 2 m/s^2\n", f"acceleration: 2 m/s^2\n      {task}\n")
    program = f"""\
        cbdsl: 1
        kind: program
        name: go
        robot: sixaxis
        stage: empty
        controllers:
          go: {{potential: spring, reference: here, feedback: arm.{kind}, effector: arm, {options}}}
        actions: [go]
        policy: {{X: go, "0": go}}
        """
    stage = "cbdsl: 1\nkind: stage\nname: empty\nrobot: sixaxis\ncontexts: {only: {}}\n"
    (folder / "robots").mkdir()
    (folder / "programs").mkdir()
    (folder / "robots" / "sixaxis.yaml").write_text(robot, "utf-8")
    (folder / "programs" / "go.yaml").write_text(dedent(program), "utf-8")
    (folder / "programs" / "stages").mkdir()
    (folder / "programs" / "stages" / "empty.yaml").write_text(stage, "utf-8")
    program_of = check_program("go", {}, Library(folder))
    return program_of.primitives["go"].lead.arrival


@pytest.mark.parametrize(
    ("options", "task", "kind", "expected"),
    [
        ("", "", "position", (0.02,)),
        ("", "", "orientation", (math.radians(5),)),
        ("arrival: 3 mm", "arrival: 1 cm", "position", (0.003,)),
        ("", "arrival: 1 cm", "position", (0.01,)),
        ("arrival: rest", "arrival: 1 cm", "position", (math.inf,)),
        (f"quiescence: {{{_RATES}, tolerance: 6 cm}}", "arrival: 1 cm", "position", (0.06,)),
        (f"quiescence: {{{_RATES}, within: 0.1}}", "arrival: 1 cm", "position", (math.inf,)),
        (f"quiescence: {{{_RATES}}}", "arrival: 1 cm", "position", (0.01,)),
        (f"quiescence: {{{_RATES}}}", "", "position", (0.02,)),
    ],
)
def test_arrival_is_the_controllers_the_robots_or_the_types(
    tmp_path: Path, options: str, task: str, kind: str, expected: tuple[float, ...]
) -> None:
    assert arrival(tmp_path, options, task, kind) == expected


def test_arrival_in_a_wrong_unit_is_reported(tmp_path: Path) -> None:
    with pytest.raises(DiagnosticsError, match="expected length"):
        arrival(tmp_path, "arrival: 3 deg")
