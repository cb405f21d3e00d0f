"""Structural patches: exits that lead back and skip no step, and other effectors."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import pytest

from cbdsl.api.load import load
from cbdsl.yaml_text.composer import compose
from cbdsl_why.patches import patches
from cbdsl_why.structural_patches import ALLOCATION, EXITS, PatchedText, changed_exits
from tests.cli.test_main import cb
from tests.conftest import ROOT

PROGRAMS = sorted((ROOT / "programs").glob("*.yaml"))
WITH_STEPS = [file for file in PROGRAMS if "\nsteps:" in file.read_text("utf-8")]

FAR = """\
cbdsl: 1
kind: program
name: far
robot: dexter
stage: absent
parameters: {arm: left_arm, y: -95 cm}
controllers:
  reach:
    potential: spring
    reference: [40 cm, $y, 10 cm]
    feedback: $arm.position
    effector: $arm.position
    quiescence: {rate: 1e-4, window: 0.3 s, tolerance: 2 cm}
steps:
  reach: {then: succeed}
limits: {transitions: 4, transition_time: 20 s}
"""


def read(text: str, file: Path = Path("own.yaml")) -> PatchedText:
    return PatchedText(file, text, compose(text, str(file)).root)


def shortest(text: str) -> dict[str, float]:
    """Return the least number of exits from each step to success, by Bellman and Ford."""
    steps = compose(text, "own.yaml").root.plain()["steps"]  # type: ignore[index]
    targets = {name: set(_targets(step or {})) for name, step in steps.items()}
    far = dict.fromkeys(targets, float("inf")) | {"succeed": 0.0}
    for _ in targets:
        for name, tos in targets.items():
            far[name] = min([far[name], *(1 + far.get(to, float("inf")) for to in tos)])
    return far


def _targets(step: dict[str, object]) -> list[str]:
    entries = step.get("exits", [])
    assert isinstance(entries, list)
    targets = [step.get("then"), step.get("failed"), *(to for e in entries for to in e.values())]
    return [str(to) for to in targets if to is not None]


@pytest.mark.parametrize("file", WITH_STEPS, ids=lambda file: file.stem)
def test_changed_exits_of_a_program_bring_no_step_nearer_to_success(file: Path) -> None:
    text = file.read_text("utf-8")
    before = shortest(text)
    made = list(changed_exits(read(text, file)))
    assert len({patch.text for patch in made}) == len(made)
    for patch in made:
        after = shortest(patch.text)
        assert all(after[name] >= distance for name, distance in before.items()), str(patch)
        assert patch.text.count("succeed") == text.count("succeed")


def test_exits_to_an_end_come_first_and_then_missing_ones() -> None:
    text = "steps:\n  grasp:\n    then: lift\n    exits: [lost: end]\n  lift: {then: succeed}\n"
    made = list(changed_exits(read(text), ["grasp"]))
    assert [str(each) for each in made] == [
        "own.yaml:4 steps.grasp.exits.0.lost: end -> grasp",
        "own.yaml:3 steps.grasp.failed: none -> grasp",
        "own.yaml:3 steps.grasp.then: lift -> grasp",
        "own.yaml:5 steps.lift.failed: none -> grasp",
        "own.yaml:5 steps.lift.failed: none -> lift",
    ]
    assert "  grasp:\n    failed: grasp\n    then: lift\n" in made[1].text
    assert "  lift: {failed: lift, then: succeed}\n" in made[-1].text


def test_families_take_turns_and_the_world_changes_last() -> None:
    made = patches(load("pick_and_lift"), "stated")
    families = [each.family for each in made]
    assert families[0] == EXITS
    assert set(families[-3:]) <= {"mass", "friction"}
    numbers = [each for each in families if each not in (EXITS, ALLOCATION, "mass", "friction")]
    assert max(Counter(numbers[: len(set(numbers))]).values()) == 1


def test_likely_families_take_more_turns_and_active_controllers_come_first() -> None:
    request = load("pick_and_place")
    families = [each.family for each in patches(request, "slip")]
    first = families[: 4 * len(set(families))]
    assert 0 < first.count("gain") < first.count("speed")
    speeds = [each.keys for each in patches(request, "slip") if each.family == "speed"]
    name = speeds[-1][1]
    assert name != speeds[0][1]
    changed = patches(request, "slip", active=(str(name),))
    assert name in next(each.keys for each in changed if each.family == "speed")


def test_why_offers_the_other_arm_for_a_place_out_of_reach(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "far.yaml"
    file.write_text(FAR, "utf-8")
    words = ("why", str(file), "--backend", "kinematic", "--apply", "--json")
    assert cb(monkeypatch, *words) == 0
    row = json.loads(capsys.readouterr().out)
    assert row["cause"]["kind"] in ("out_of_reach", "stuck")
    assert row["patch"]["edit"].endswith("parameters.arm: left_arm -> right_arm")
    assert (row["patch"]["before"], row["patch"]["after"]) == (0, 5)
    assert "arm: right_arm" in file.read_text("utf-8")
    # A value of the command line stays.
    words = (
        "why",
        str(file),
        "--backend",
        "kinematic",
        "--try",
        "--json",
        "--with",
        "arm=left_arm",
    )
    assert cb(monkeypatch, *words) == 0
    assert json.loads(capsys.readouterr().out)["patch"] is None
