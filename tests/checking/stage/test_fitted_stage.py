"""Tests of stages for any robot."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.stage.fitted_stage import UnfitStageError, fitted_stage
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.bench import bench
from cbdsl.yaml_text.library import Library

ROBOTS = Library().names(RobotDocument)


@pytest.mark.parametrize("name", ROBOTS)
def test_stage_for_any_robot_scales_with_its_reach(name: str) -> None:
    library, file = Library(), Path("robots", f"{name}.yaml")
    robot = library.read(file, RobotDocument).document
    loaded = library.read(Path("programs/stages/over_bench.yaml"), StageDocument)
    stage, before = fitted_stage(loaded, robot, file), bench(robot, file)
    radius = stage.things["ball"].form.radius  # type: ignore[union-attr]
    assert stage.robot == name
    assert radius == pytest.approx((0.04 * before.reach, 0.06 * before.reach))
    x = stage.contexts["held"].place.x  # type: ignore[union-attr]
    assert (x[0] + x[1]) / 2 == pytest.approx(before.position[0])


def test_span_needs_a_robot_that_states_one() -> None:
    library = Library()
    loaded = library.read(Path("programs/stages/cube_on_bench.yaml"), StageDocument)
    for name, problem in (("desk", "states no 'span'"), ("panda", "")):
        file = Path("robots", f"{name}.yaml")
        robot = library.read(file, RobotDocument).document
        if not problem:
            assert fitted_stage(loaded, robot, file).robot == name
            continue
        with pytest.raises(UnfitStageError, match=problem):
            fitted_stage(loaded, robot, file)


@pytest.mark.parametrize(
    ("radius", "problem"),
    [
        ("0.1 reach - 1 N", "'1 N' is no length"),
        ("-0.1 reach", "greater than 0"),
    ],
)
def test_measure_that_no_length_follows_from_is_one_finding(
    radius: str, problem: str, tmp_path: Path
) -> None:
    path = tmp_path / "stage.yaml"
    path.write_text(
        "cbdsl: 1\nkind: stage\nname: stage\nrobot: any\n"
        f"things: {{ball: {{form: {{shape: ball, radius: {radius}}}, mass: 1 kg}}}}\n"
        "contexts: {here: {things: [ball], place: {x: bench.x, y: bench.y, z: bench.z}}}\n"
    )
    (found,) = check_document(path)
    assert found.code in ("CB358", "CB201") and problem in found.message
    file = Path("robots", "desk.yaml")
    library = Library()
    with pytest.raises(UnfitStageError):
        fitted_stage(
            library.read(path, StageDocument), library.read(file, RobotDocument).document, file
        )


@pytest.mark.parametrize(("hand", "codes"), [("arm", []), ("tail", ["CB351"])])
def test_stage_for_any_robot_fits_first_robot_with_its_parts(
    hand: str, codes: list[str], tmp_path: Path
) -> None:
    # The first robot at hand with a span has two arms; another one has an ``arm``.
    path = tmp_path / "stage.yaml"
    path.write_text(
        "cbdsl: 1\nkind: stage\nname: stage\nrobot: any\n"
        "things: {ball: {form: {shape: ball, radius: 0.2 span}, mass: 1 kg}}\n"
        f"contexts: {{here: {{things: [ball], place: {{hand: {hand}, gap: 0.1 span}}}}}}\n"
    )
    assert [found.code for found in check_document(path)] == codes
