"""``cb compare``: counts, interval, the first difference and its cause."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.arguments.test_revision import git
from tests.cli.arm_program import TEXT
from tests.cli.test_main import cb

_SIDES = ("searchtrack,backend=kinematic", "searchtrack,backend=kinematic,stage=absent")


def test_compare_as_json_explains_the_first_difference(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "compare", *_SIDES, "--seeds", "0-1", "--all", "--json") == 0
    row = json.loads(capsys.readouterr().out)
    assert (row["seeds"], row["successes"], row["alone"]) == ([0, 1], [2, 0], [2, 0])
    assert row["interval"][0] == row["difference"] == -1.0
    first = row["first_difference"]
    assert (first["seed"], first["failed"]) == (0, "B")
    assert first["cause"]["kind"] == "never_seen"


def test_compare_runs_a_program_of_a_revision(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "raise_arm.yaml"
    file.write_text(TEXT, "utf-8")
    git(tmp_path, "init", "-q")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "-q", "-m", "raise the arm")
    file.write_text(f"{TEXT}limits: {{episode_time: 0.1 s}}\n", "utf-8")
    sides = [f"{file}{revision},backend=kinematic" for revision in ("@HEAD", "")]
    assert cb(monkeypatch, "compare", *sides, "--seeds", "0-1", "--all", "--json") == 0
    row = json.loads(capsys.readouterr().out)
    assert (row["successes"], row["first_difference"]["failed"]) == ([2, 0], "B")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ((*_SIDES, "--seeds", "5"), "first and the last seed"),
        ((_SIDES[0], "reach,stage"), "expected name=value"),
    ],
)
def test_compare_of_unreadable_words_is_refused(
    words: tuple[str, ...],
    told: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert cb(monkeypatch, "compare", *words) == 2
    assert told in capsys.readouterr().err
