"""``cb report``: a page is written in one step, or a message gives the reason."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from tests.cli.test_main import cb
from tests.conftest import ROOT
from tests.reporting.trials import write_trial


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Change to a working folder with the trials of a lesson in ``knowledge``."""
    (tmp_path / "knowledge").mkdir()
    for seed in (0, 1):
        write_trial(tmp_path / "knowledge", f"walked_{seed}", seed)
    (tmp_path / "empty").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_report_writes_the_page_beside_the_policy(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "report", "knowledge/walked_0.yaml") == 0
    assert capsys.readouterr().out == "knowledge/walked_0.html: 0.1 MB\n"
    text = Path("knowledge/walked_0.html").read_text("utf-8")
    assert text.startswith("<!doctype html>") and text.count('<section class="trial"') == 1


def test_folder_has_one_page_of_all_its_trials(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert cb(monkeypatch, "report", "knowledge") == 0
    text = Path("knowledge/report.html").read_text("utf-8")
    assert text.count('<section class="trial"') == 2
    # The page is not a policy: the same command makes the same page again.
    assert cb(monkeypatch, "report", "knowledge") == 0
    assert Path("knowledge/report.html").read_text("utf-8") == text


def test_meta_catalog_has_a_page_that_plans(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (ROOT / "knowledge" / "meta_catalogs" / "four_things.yaml").read_text("utf-8")
    Path("things.yaml").write_text(text, encoding="utf-8")
    assert cb(monkeypatch, "report", "things.yaml", "--out", "things.html") == 0
    assert "Plan a stack" in Path("things.html").read_text("utf-8")
    Path("bad.yaml").write_text(text.replace("lower: blue_box", "lower: bleu_box"), "utf-8")
    assert cb(monkeypatch, "report", "bad.yaml") == 1
    assert not Path("bad.html").exists()


def test_failed_write_keeps_the_existing_page(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    target = folder / "empty" / "page.html"
    target.write_text("before", encoding="utf-8")
    monkeypatch.setattr(os, "replace", fail)
    assert cb(monkeypatch, "report", "knowledge", "--out", str(target)) == 2
    assert "cannot be written (No space left on device)" in capsys.readouterr().err
    assert target.read_text("utf-8") == "before"
    assert [each.name for each in target.parent.iterdir()] == ["page.html"]


MISTAKES = [
    (["none.yaml"], 2, "none.yaml: there is no such file"),
    (["empty"], 2, "empty: no policy is in this folder"),
    (["knowledge/walked_0_head.yaml"], 1, "CB201"),
    (["knowledge/walked_0.episodes.jsonl"], 2, "name the policy"),
    (["knowledge/walked_0.yaml", "--out", "knowledge/walked_0.yaml/a.html"], 2, "be written"),
    (["knowledge/walked_0.yaml", "--out", "knowledge/walked_0.yaml"], 2, "would overwrite"),
    (["knowledge/walked_0.yaml", "--above", "-1"], 2, "--above"),
    ([], 2, "FILE|FOLDER"),
]


@pytest.mark.parametrize(
    ("arguments", "code", "named"), MISTAKES, ids=[" ".join(m[0]) for m in MISTAKES]
)
def test_report_with_wrong_arguments_prints_one_message(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    code: int,
    named: str,
) -> None:
    assert cb(monkeypatch, "report", *arguments) == code
    out, err = capsys.readouterr()
    assert named in out + err
    assert "Traceback" not in err and "internal error" not in err
    assert not list(folder.rglob("*.html"))


def test_report_opens_a_browser_only_on_a_terminal(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[str] = []
    monkeypatch.setattr("typer.launch", opened.append)
    assert cb(monkeypatch, "report", "knowledge") == 0
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    assert cb(monkeypatch, "report", "knowledge", "--no-open") == 0
    assert opened == []
    assert cb(monkeypatch, "report", "knowledge") == 0
    assert opened == [str(Path("knowledge/report.html"))]


def test_report_without_numpy_names_the_extra(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in [*sys.modules]:
        if name == "numpy" or name.startswith(("cbdsl.reporting", "cbdsl_report.")):
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "numpy", None)
    assert cb(monkeypatch, "report", "knowledge") == 2
    assert "pip install 'cbdsl[sim]'" in capsys.readouterr().err


def test_report_of_a_named_pipe_says_so(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    os.mkfifo(folder / "pipe.yaml")
    try:
        assert cb(monkeypatch, "report", "pipe.yaml") == 1
    finally:
        (folder / "pipe.yaml").unlink()
    assert "it is a named pipe" in capsys.readouterr().out
