"""Uses of one program are distinguished in all reports of an episode."""

from __future__ import annotations

from pathlib import Path

import pytest

import cbdsl
from cbdsl.program.transition import Transition, title_of
from cbdsl.reporting.page import page
from cbdsl.reporting.recorded import read_recording
from tests.cli.test_main import cb
from tests.reporting.browser import CHROMIUM, browser

TWO = """\
cbdsl: 1
kind: program
name: two
robot: dexter
stage: absent
use:
  left: {program: posture, with: {arm: left_arm, posture: ready}}
  right: {program: posture, with: {arm: right_arm, posture: home}}
controllers: {}
actions: [left, right]
policy: {XX: left, 0X: left, 1X: right, X0: right}
success: [X1]
"""
OUTER = """\
cbdsl: 1
kind: program
name: outer
robot: dexter
stage: absent
use: {both: {program: two}, posture: {program: posture}}
controllers: {}
actions: [both, posture]
policy: {XX: both, 0X: both, 1X: posture, X0: posture}
success: [X1]
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "programs").mkdir()
    for name, text in (("two", TWO), ("outer", OUTER)):
        (tmp_path / "programs" / f"{name}.yaml").write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_transitions_name_the_use_of_their_program(here: Path) -> None:
    passed: list[Transition] = []
    cbdsl.run("outer", backend="kinematic", on_transition=passed.append)
    assert {(each.program, each.use, each.title) for each in passed} == {
        ("outer", "", "outer"),
        ("two", "both", "both (two)"),
        ("posture", "both.left", "both.left (posture)"),
        ("posture", "both.right", "both.right (posture)"),
        ("posture", "posture", "posture"),
    }


def test_ending_names_the_use_that_ended(here: Path) -> None:
    (result,) = cbdsl.run("two", backend="kinematic")
    assert "right (posture) has no action for state 1" in result.ending


def test_cb_run_prints_the_use_of_a_program(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "run", "two", "--backend", "kinematic") == 0
    shown = capsys.readouterr().out
    assert "left (posture)  X -> 0  move" in shown and "right (posture)  X -> 0  move" in shown


def test_title_of_a_use_under_its_own_name_is_short() -> None:
    assert title_of("reach", "") == title_of("reach", "reach") == "reach"
    assert title_of("reach", "a.reach") == "a.reach"
    assert title_of("reach", "overreach") == "overreach (reach)"


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_page_of_an_episode_has_rows_for_each_use(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ("run", "two", "--backend", "kinematic", "--record", "kept")
    assert cb(monkeypatch, *words) == 0
    (file,) = (here / "kept").glob("episode_*.json")
    shown = here / "episode.html"
    shown.write_text(page(read_recording(file)), encoding="utf-8")
    with browser() as opened:
        opened.open(shown)
        rows = opened.value(
            "[...document.querySelectorAll('.program')].map((row) => row.textContent)"
        )
        assert opened.errors == []
    titles = ("two", "left (posture)", "right (posture)")
    assert [sum(row.startswith(title) for row in rows) for title in titles] == [1, 1, 1], rows
