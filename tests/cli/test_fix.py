"""``cb validate --fix``: unambiguous misspellings are corrected, and all else stays."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.test_main import cb
from tests.conftest import ROOT

TEXT = (ROOT / "programs" / "searchtrack.yaml").read_text("utf-8")


def test_misspelled_names_are_corrected_in_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "searchtrack.yaml"
    spoiled = TEXT.replace("potential: spring", "potential: sprung").replace(
        "effector: head", "effector: haed"
    )
    path.write_text(spoiled, encoding="utf-8")
    assert cb(monkeypatch, "validate", str(path)) == 1
    assert path.read_text("utf-8") == spoiled
    assert cb(monkeypatch, "validate", str(path), "--fix") == 0
    assert path.read_text("utf-8") == TEXT
    assert f"fixed {path}" in capsys.readouterr().err


def test_uncertain_matches_are_skipped_and_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "searchtrack.yaml"
    spoiled = TEXT.replace("potential: spring", "potential: xyzzy", 1)
    path.write_text(spoiled, encoding="utf-8")
    assert cb(monkeypatch, "validate", str(path), "--fix") == 1
    assert path.read_text("utf-8") == spoiled
    printed = capsys.readouterr()
    assert "xyzzy" in printed.out and "fixed" not in printed.err


def test_standard_input_cannot_be_corrected(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "validate", "-", "--fix") == 2
    assert "--fix writes files" in capsys.readouterr().err
