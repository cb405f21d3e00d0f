"""Damaged lines in files of ``cb reproduce --keep``: reported by number, without loss of data."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from test_reproduce import KEPT, cb, toys

from cbdsl.storage.journal import damaged
from cbdsl_reproduction import registry
from cbdsl_reproduction.experiment import RunSettings
from cbdsl_reproduction.kept_files import damaged_lines
from cbdsl_reproduction.kept_rows import KeptRows

__all__ = ["toys"]


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, toys: list[RunSettings]) -> Path:
    """Write three rows to a file in an experiment's folder, and return its path."""
    monkeypatch.setattr(registry, "EXPERIMENTS", {KEPT.name: KEPT})
    path = tmp_path / "trials" / "bullet_ideal.jsonl"
    for seed in range(3):
        KeptRows(path).add({"what": "x", "seed": seed})
    return path


def damage(path: Path, line: bytes) -> bytes:
    """Replace the second line of a file, and return the new content."""
    first, _, third = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(first + line + b"\n" + third)
    return path.read_bytes()


def test_sound_files_and_journals_of_learning_are_passed(kept: Path) -> None:
    (kept.parent / "trial_1.episodes.jsonl").write_text("garbage\n")
    assert list(damaged_lines(kept.parent)) == []


def test_line_that_was_cut_off_is_reported_and_the_rest_goes_on(
    kept: Path,
    toys: list[RunSettings],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    held = damage(kept, b'{"what": "x", "se')
    assert cb(monkeypatch, KEPT.name, "--keep", str(kept.parent)) == 0
    told = capsys.readouterr().err
    assert f"warning: {kept}, line 2: it is not JSON; it is passed over" in told
    assert "run again" in told and len(toys) == 1 and kept.read_bytes() == held
    assert [row["seed"] for row in KeptRows(kept)] == [0, 2]


@pytest.mark.parametrize(
    ("line", "problem"), [(b"\xff\xfe\x00garbage", "not UTF-8"), (b"12", "not a row of a trial")]
)
def test_line_that_cannot_be_passed_over_stops_with_its_number_and_a_remedy(
    line: bytes,
    problem: str,
    kept: Path,
    toys: list[RunSettings],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    held = damage(kept, line)
    assert cb(monkeypatch, KEPT.name, "--keep", str(kept.parent)) == 2
    told = capsys.readouterr().err
    assert f"{kept}, line 2: it is {problem}" in told and "internal error" not in told
    assert "delete this line" in told and not toys and kept.read_bytes() == held
    rows = held.splitlines(keepends=True)
    kept.write_bytes(rows[0] + rows[2])  # remove the line, as the message advises
    assert cb(monkeypatch, KEPT.name, "--keep", str(kept.parent)) == 0
    assert [json.loads(row)["seed"] for row in kept.read_text().splitlines()] == [0, 2]


def test_damaged_journal_of_learning_is_not_called_one_of_other_trials(
    kept: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def run(settings: RunSettings) -> None:
        raise damaged(settings.folder / "a.episodes.jsonl", 3, "it is not JSON")

    monkeypatch.setattr(sys.modules["cbdsl_reproduction.toy"], "run", run)
    assert cb(monkeypatch, KEPT.name, "--keep", str(kept.parent)) == 2
    told = capsys.readouterr().err
    assert "a.episodes.jsonl, line 3: it is not JSON" in told and "other trials" not in told
    assert "head -n 2 " in told and "the same command goes on there" in told
