"""Values given to shared controllers, used programs and parameters, and their meanings."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from cbdsl.api.load import load
from cbdsl_why.given_values import GivenValues, ParameterScope
from cbdsl_why.patches import patches
from cbdsl_why.structural_patches import ALLOCATION, EXITS
from tests.conftest import ROOT

_HEAD = "cbdsl: 1\nkind: {0}\nname: {1}\nrobot: dexter\n"
_SHARED = (
    _HEAD.format("shared", "pressing")
    + """\
parameters: {force: 2 N, pace: 1 /s, most: 3 N, near: 2 cm, x: 40 cm}
controllers:
  close(force, pace):
    potential: spring
    reference: $force along normals
    feedback: right_hand.finger_forces
    effector: right_hand
    gain: $pace
  gently(force): close($force, 0.5 /s)
  lighter(most):
    potential: at_most
    reference: $most
    axes: [z]
    feedback: right_hand.net.force
    effector: right_arm.position
  go(x, near):
    potential: spring
    reference: [$x, -30 cm, 10 cm]
    feedback: right_arm.position
    effector: right_arm.position
    quiescence: {rate: 1e-4, window: 0.3 s, tolerance: $near}
  never(force):
    potential: spring
    reference: $force along normals
    feedback: right_hand.finger_forces
    effector: right_hand
"""
)
_INNER = (
    _HEAD.format("program", "inner")
    + """\
stage: absent
parameters: {force: 4 N, height: 40 cm, both: 3 N}
shared: {pressing: [close, gently, go, lighter]}
controllers:
  go: go($height, 2 cm)
  close: "close($force, 2 /s)"
  gently: gently($both)
  lighter: lighter($both)
steps:
  go: {then: close}
  close: {then: gently}
  gently: {do: lighter ◁ gently, then: succeed}
limits: {transitions: 4, transition_time: 20 s}
"""
)
_OUTER = (
    _HEAD.format("program", "outer")
    + """\
stage: absent
parameters: {firm: 8 N}
use:
  first: {program: inner, with: {force: $firm}}
  then: {program: inner, with: {force: 5 N, both: 1 N, height: 30 cm}}
steps:
  first: {then: then}
  then: {then: succeed}
limits: {transitions: 4, transition_time: 20 s}
"""
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a program that uses another one, which calls shared controllers."""
    made = tmp_path_factory.mktemp("given")
    for name, text in (("pressing", _SHARED), ("inner", _INNER), ("outer", _OUTER)):
        (made / f"{name}.yaml").write_text(text, "utf-8")
    return made


def _changed(folder: Path, given: tuple[str, ...] = ()) -> set[str]:
    made = patches(load(folder / "outer.yaml"), "slip", (), given)
    return {f"{each.file.stem} {'.'.join(map(str, each.keys))}: {each.before}" for each in made}


def test_numbers_of_calls_of_used_programs_and_of_parameters_are_changed(folder: Path) -> None:
    changed = {
        each
        for each in _changed(folder)
        if not each.startswith("absent") and " limits." not in each
    }
    exits = {each for each in changed if " steps." in each}
    assert changed - exits == {
        "outer parameters.firm: 8 N",
        "outer use.then.with.force: 5 N",
        "inner parameters.force: 4 N",
        "inner controllers.close.pace: 2 /s",
        "pressing controllers.gently(force).pace: 0.5 /s",
        "pressing controllers.go(x, near).quiescence.window: 0.3 s",
    }
    assert not {each for each in _changed(folder, ("firm",)) if "parameters.firm" in each}


def test_change_of_an_argument_leaves_the_rest_of_its_call(folder: Path) -> None:
    made = patches(load(folder / "outer.yaml"), "slip")
    edits = [each for each in made if each.keys == ("controllers", "close", "pace")]
    assert [each.after for each in edits] == ["1 /s", "4 /s", "20 /s"]
    for each in edits:
        assert f'  close: "close($force, {each.after})"\n' in each.text


@pytest.mark.parametrize(
    ("name", "part", "parameter", "key"),
    [
        ("pressing", "close", "force", "reference"),
        ("pressing", "close", "pace", "gain"),
        ("pressing", "gently", "force", "reference"),
        ("pressing", "lighter", "most", ""),
        ("pressing", "go", "near", ""),
        ("inner", "", "force", "reference"),
        ("inner", "", "both", ""),
        ("inner", "", "height", ""),
        ("outer", "", "firm", "reference"),
        ("outer", "", "absent", ""),
    ],
)
def test_parameter_stands_for_the_only_key_that_it_is_written_at(
    folder: Path, name: str, part: str, parameter: str, key: str
) -> None:
    values = GivenValues(load(folder / "outer.yaml").library, ("reference", "gain", "speed"))
    assert values.meaning(ParameterScope(folder / f"{name}.yaml", part), parameter) == key


@pytest.mark.parametrize("name", ["bring", "fetch", "pick_and_place", "press_and_slide", "stack"])
def test_patches_of_numbers_differ_and_change_one_line(name: str) -> None:
    request = load(ROOT / "programs" / f"{name}.yaml")
    made = [each for each in patches(request, "slip") if each.family not in (EXITS, ALLOCATION)]
    assert len({(each.file, each.text) for each in made}) == len(made)
    for each in made:
        lines = zip(
            request.library.text(each.file).splitlines(), each.text.splitlines(), strict=True
        )
        ((before, after),) = [pair for pair in lines if pair[0] != pair[1]]
        assert each.before in before and each.after in after
        tolerances = [re.findall("tolerance: [^,}]+", line) for line in (before, after)]
        assert tolerances[0] == tolerances[1]
