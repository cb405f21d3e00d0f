"""``cb explore --thing`` and ``cb show meta-catalog``: pairs of objects that stay stacked."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.documents.meta_catalog import MetaCatalogDocument
from cbdsl.yaml_text.library import Library
from tests.cli.test_learn import cb

BOXES = ["--thing", "blue_box=blue", "--thing", "purple_box=hue_9"]
ON = ["--stage", "stacking", "--seed", "4"]
WORDS = ["explore", "stand", *BOXES, *ON, "--out", "boxes.yaml"]
FAST = ["--backend", "kinematic", "--set", "least=1"]

STACK = ["--thing", "purple_box_on_blue_box=@four_things"]
BALL = ["--thing", "football=green"]

MISTAKES = [
    (["stand", *BALL, *STACK], ["'stand' brings no thing to a stack", "parameter 'base'"]),
    (["build_on", "--thing", "slab=blue", *STACK], ["another thing has the channel 'blue'"]),
    (["build_on", *BALL, STACK[0], f"{STACK[1]}x"], ["four_thingsx"]),
    (
        ["build_on", *BALL, "--thing", "purple_box_on_blue_bx=@four_things"],
        ["unknown pair of 'four_things'", "did you mean 'purple_box_on_blue_box'"],
    ),
    (["build_on", *BALL, "--thing", "blue_box_on_football=@four_things"], ["never stayed"]),
    (
        ["build_on", *BALL, "--thing", "purple_box_on_blue_box=@things_in_touch"],
        ["'four_things', not of 'things_in_touch'"],
    ),
    (["stand", "--thing", "blue_box"], ["NAME=CHANNEL"]),
    (["stand", "--thing", "blue_box=blue"], ["two things at least"]),
    (["stand", *BOXES, "--thing", "slab=blue"], ["another thing has the channel 'blue'"]),
    (["stand", *BOXES, "--thing", "blue_box=red"], ["'blue_box' is there twice"]),
    (["stand", "stack", *BOXES], ["one PROGRAM"]),
    (["stand", *BOXES, "--relation", "under"], ["under", "on, in"]),
    (["stand", *BOXES, "--relation", "in"], ["shows no pair", "_in_"]),
    (["stand", *BOXES, "--feature", "red"], ["--feature means nothing with --thing"]),
    (["stand", *BOXES, "--set", "alfa=1"], ["did you mean 'alpha'"]),
    (["reachtouch", *BOXES], ["reachtouch", "'goal'"]),
    (["stand", "--thing", "blue_box=blu", "--thing", "purple_box=hue_9"], ["blu"]),
]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(("words", "named"), MISTAKES, ids=lambda each: str(each)[-60:])
def test_explore_pairs_with_wrong_arguments_names_the_mistake(
    words: list[str],
    named: list[str],
    here: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert cb(monkeypatch, "explore", *words, *ON, "--out", "a.yaml") in (1, 2)
    told = "".join(capsys.readouterr())
    assert all(each in told for each in named), told
    assert "internal error" not in told
    assert not (here / "a.yaml").exists()


def read(path: Path) -> MetaCatalogDocument:
    assert not check_document(path)
    return Library().read(path, MetaCatalogDocument).document


def test_resumed_exploration_of_pairs_repeats_no_action(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, *WORDS, *FAST, "--actions", "1") == 0
    first = read(here / "boxes.yaml")
    kept = (here / "boxes.actions.jsonl").read_text("utf-8")
    assert cb(monkeypatch, *WORDS, *FAST, "--actions", "2", "--resume") == 0
    assert (here / "boxes.actions.jsonl").read_text("utf-8").startswith(kept)
    whole = read(here / "boxes.yaml")
    assert whole.steps is not None and first.steps is not None
    assert whole.steps.action[:1] == first.steps.action
    # Untried pairs come first.
    assert {each.tried for each in whole.pairs.values()} == {1}
    stayed = {name: each.rewarded for name, each in whole.pairs.items()}
    assert stayed == {"purple_box_on_blue_box": 1, "blue_box_on_purple_box": 0}
    capsys.readouterr()
    assert cb(monkeypatch, *WORDS, *FAST, "--actions", "2") == 2
    assert "--resume" in "".join(capsys.readouterr())
    assert cb(monkeypatch, "show", "meta-catalog", "boxes.yaml", "--stack", "2") == 0
    assert capsys.readouterr().out.startswith("blue_box < purple_box")
    assert cb(monkeypatch, "show", "meta-catalog", "boxes.yaml", "--stack", "3") == 2
    assert "no stack of 3 is known of blue_box, purple_box" in "".join(capsys.readouterr())


@pytest.mark.slow
def test_small_box_stands_on_a_large_one_and_not_vice_versa(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    engine = ["--backend", "mujoco", "--cameras", "ideal"]
    assert cb(monkeypatch, *WORDS, *engine, "--actions", "6") == 0
    pairs = read(here / "boxes.yaml").pairs
    assert pairs["purple_box_on_blue_box"].rewarded >= 2
    assert pairs["blue_box_on_purple_box"].rewarded == 0
    seen = pairs["purple_box_on_blue_box"].with_reward
    assert seen is not None
    # The upper object is half as large and above the lower one, without lateral offset.
    assert seen.mean[0] == pytest.approx(0.5, abs=0.15)
    assert max(map(abs, seen.mean[3:5])) < 0.06 < seen.mean[5]


def test_meta_catalog_is_printed_drawn_and_planned(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    show = ["show", "meta-catalog", "four_things"]
    assert cb(monkeypatch, *show) == 0
    told = capsys.readouterr().out
    assert "purple_box on blue_box" in told and "stereo.hue_9.to.blue" in told
    assert cb(monkeypatch, *show, "--svg") == 0
    assert capsys.readouterr().out.startswith("<svg")
    assert cb(monkeypatch, *show, "--json") == 0
    assert json.loads(capsys.readouterr().out)["kind"] == "meta_catalog"
    assert cb(monkeypatch, *show, "--stack", "3", "--of", "football,purple_box,blue_box") == 0
    planned = capsys.readouterr().out
    assert planned.startswith("blue_box < purple_box < football")
    command = "cb run stack_three --with goal=blue --with middle=hue_9 --with feature=green"
    assert planned.splitlines()[1].startswith(command)
    assert cb(monkeypatch, *show, "--stack", "2", "--json") == 0
    below = json.loads(capsys.readouterr().out)["order"][0]
    assert below in ("blue_box", "purple_box"), "nothing stands on a ball"
    assert cb(monkeypatch, *show, "--of", "football") == 2
    assert cb(monkeypatch, *show, "--stack", "3", "--of", "footbal") == 2
    assert "football" in "".join(capsys.readouterr())


def test_explore_with_a_stack_as_an_object_writes_a_catalog_above_the_stacks(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["explore", "build_on", *BALL, *STACK, "--stage", "stack_and_more", "--seed", "5"]
    assert cb(monkeypatch, *words, *FAST, "--actions", "1", "--out", "grown.yaml") == 0
    document = read(here / "grown.yaml")
    stack, pair = "purple_box_on_blue_box", "football_on_purple_box_on_blue_box"
    assert document.over == ("four_things",)
    assert document.things[stack].meta_catalog == "four_things"
    # A hand takes one object, so that the stack is the lower one.
    assert [*document.pairs] == [pair]
    assert document.pairs[pair].lower == stack
    assert {"base": "blue", "pair": stack}.items() <= document.pairs[pair].with_.items()
    signals = {each.signal for each in document.pairs[pair].features.values()}
    assert {"stereo.green.to.hue_9", "stereo.hue_9.to.blue"} <= signals
    capsys.readouterr()
    assert cb(monkeypatch, "show", "meta-catalog", "grown.yaml") == 0
    assert f"{stack} (hue_9, stack of four_things)" in capsys.readouterr().out
    assert cb(monkeypatch, "show", "meta-catalog", "grown.yaml", "--svg") == 0


def test_shipped_catalog_of_a_stack_gives_programs_the_likeness_of_the_grown_stack(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "sees.yaml").write_text(
        """\
cbdsl: 1
kind: program
name: sees
robot: dexter
stage: stack_and_more
meta_catalog: things_on_a_stack
controllers:
  is_it:
    potential: at_least
    reference: 0.001
    feedback: likeness.football_on_purple_box_on_blue_box
    effector: head
    gain: 1 /s
    quiescence: {rate: 1e-6, window: 0.5 s, tolerance: 1e-5}
actions: [is_it]
policy: {X: is_it}
"""
    )
    assert cb(monkeypatch, "validate", "sees.yaml") == 0, capsys.readouterr()
