"""``cb fmt``: files are replaced, checked or shown, and what is no YAML is told."""

from __future__ import annotations

import io
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.cli.test_main import cb
from tests.conftest import ROOT

UNEVEN = "cbdsl:   1  # version\nkind: program\n\n\nname:  uneven\n"
EVEN = "cbdsl: 1  # version\nkind: program\n\nname: uneven\n"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "uneven.yaml").write_text(UNEVEN, encoding="utf-8")
    (tmp_path / "even.yaml").write_text(EVEN, encoding="utf-8")
    return tmp_path


def test_files_that_change_are_replaced_and_named(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    before = (here / "even.yaml").stat().st_mtime_ns
    assert cb(monkeypatch, "fmt", ".") == 0
    assert capsys.readouterr().out == "formatted uneven.yaml\n"
    assert (here / "uneven.yaml").read_text("utf-8") == EVEN
    assert (here / "even.yaml").stat().st_mtime_ns == before
    assert cb(monkeypatch, "fmt", ".") == 0
    assert capsys.readouterr().out == ""


def test_check_and_diff_write_nothing(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "fmt", "--check", ".") == 1
    assert cb(monkeypatch, "fmt", "--check", "even.yaml") == 0
    assert capsys.readouterr().out == "would format uneven.yaml\n"
    assert cb(monkeypatch, "fmt", "--diff", ".") == 0
    shown = capsys.readouterr().out
    assert "-name:  uneven\n+name: uneven\n" in shown
    assert (here / "uneven.yaml").read_text("utf-8") == UNEVEN


def test_what_is_no_yaml_is_told_and_the_rest_goes_on(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "bad.yaml").write_text("a: [1\nb: 2\n", encoding="utf-8")
    assert cb(monkeypatch, "fmt", ".") == 1
    shown = capsys.readouterr().out
    assert "bad.yaml:1:4: CB104" in shown and "formatted uneven.yaml" in shown
    assert (here / "bad.yaml").read_text("utf-8") == "a: [1\nb: 2\n"


def test_the_standard_input_is_printed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(UNEVEN.encode())))
    assert cb(monkeypatch, "fmt", "-") == 0
    assert capsys.readouterr().out == EVEN
    assert cb(monkeypatch, "fmt", "-", "--check") == 2


def test_shipped_documents_are_found_by_name(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(ROOT)
    assert cb(monkeypatch, "fmt", "--check", "dexter", "robots", "programs", "knowledge") == 0
    assert capsys.readouterr().out == ""
