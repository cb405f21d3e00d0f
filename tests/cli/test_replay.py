"""``cb replay``: pages are written in one step, or a message gives the reason."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

import pytest

from tests.cli import test_main
from tests.reporting.conftest import Record, kept, play, record

__all__ = ["Record", "kept", "play", "record"]


def cb(monkeypatch: pytest.MonkeyPatch, *arguments: str | Path) -> int:
    """Run ``cb replay`` in this process and return its exit code."""
    return test_main.cb(monkeypatch, "replay", *map(str, arguments))


@pytest.fixture
def folder(kept: Path, tmp_path: Path) -> Path:
    """Copy two recordings into a folder."""
    folder = tmp_path / "kept"
    folder.mkdir()
    for suffix in (".json", ".npz"):
        for name in ("episode_0", "episode_1"):
            shutil.copy(kept.with_suffix(suffix), folder / f"{name}{suffix}")
    return folder


def test_replay_writes_the_page_beside_the_recording(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, folder / "episode_0.json") == 0
    target = folder / "episode_0.html"
    assert capsys.readouterr().out.startswith(f"{target}: ")
    assert target.read_text("utf-8").startswith("<!doctype html>")
    assert not (folder / "episode_1.html").exists()


def test_replay_of_a_folder_writes_a_page_per_recording(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert cb(monkeypatch, folder) == 0
    pages = [folder / f"episode_{seed}.html" for seed in (0, 1)]
    assert pages[0].read_bytes() == pages[1].read_bytes()


def test_replay_writes_the_page_to_the_given_path(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert cb(monkeypatch, folder / "episode_1.npz", "--out", tmp_path / "new/far/page.html") == 0
    assert (tmp_path / "new" / "far" / "page.html").is_file()
    shutil.rmtree(tmp_path / "new")
    target = tmp_path / "page.html"
    target.write_text("before", encoding="utf-8")
    assert cb(monkeypatch, folder / "episode_1.npz", "--out", target) == 0
    assert "Why it stopped" in target.read_text("utf-8")
    assert {each.name for each in tmp_path.iterdir()} == {"kept", "page.html"}


def test_failed_write_keeps_the_existing_page(
    folder: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    target = tmp_path / "page.html"
    target.write_text("before", encoding="utf-8")
    monkeypatch.setattr(os, "replace", fail)
    assert cb(monkeypatch, folder / "episode_0.json", "--out", target) == 2
    assert "cannot be written (No space left on device)" in capsys.readouterr().err
    assert target.read_text("utf-8") == "before"
    assert {each.name for each in tmp_path.iterdir()} == {"kept", "page.html"}


MISTAKES: list[tuple[list[str], list[str]]] = [
    (["none"], ["none: there is no such file"]),
    (["kept/episode_7.json"], ["episode_7.json", "no such file"]),
    (["empty"], ["empty: no recording", "--record"]),
    (["kept", "--out", "page.html"], ["2 recordings"]),
    (
        ["kept/episode_0.json", "--out", "program.yaml/page.html"],
        ["program.yaml/page.html", "exists"],
    ),
    (["kept/episode_0.json", "--out", "empty"], ["empty: cannot be written"]),
    (["program.yaml"], ["program.yaml: no recording", "cb run PROGRAM --record FOLDER"]),
    ([], ["FILE|FOLDER"]),
]


@pytest.mark.parametrize(("arguments", "named"), MISTAKES, ids=[" ".join(m[0]) for m in MISTAKES])
def test_replay_with_wrong_arguments_prints_one_message(
    folder: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    named: list[str],
) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "program.yaml").write_text("kind: program\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert cb(monkeypatch, *arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "Traceback" not in err and "internal error" not in err
    for part in named:
        assert part in err


def test_replay_opens_a_browser_only_on_a_terminal(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    opened: list[str] = []
    monkeypatch.setattr("typer.launch", opened.append)
    file = folder / "episode_0.json"
    assert cb(monkeypatch, file) == 0
    assert opened == []
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    assert cb(monkeypatch, file, "--no-open") == 0
    assert opened == []
    assert cb(monkeypatch, file) == 0
    assert opened == [str(folder / "episode_0.html")]


def test_replay_without_numpy_names_the_extra(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in [*sys.modules]:
        if name == "numpy" or name.startswith(("cbdsl.reporting", "cbdsl.runtime")):
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "numpy", None)
    assert cb(monkeypatch, folder / "episode_0.json") == 2
    assert "pip install 'cbdsl[sim]'" in capsys.readouterr().err


SHARED = """\
cbdsl: 1
kind: shared
name: still
robot: dexter
controllers:
  ahead: {potential: spring, reference: head.ahead, feedback: head, effector: head}
"""
PROGRAM = """\
cbdsl: 1
kind: program
name: look_ahead
robot: dexter
stage: absent
shared: {still: [ahead]}
actions: [ahead]
"""


def test_replay_names_the_shared_document_by_which_the_program_has_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    shared, program = Path("programs/shared/still.yaml"), Path("programs/look_ahead.yaml")
    shared.parent.mkdir(parents=True)
    shared.write_text(SHARED, "utf-8")
    program.write_text(PROGRAM, "utf-8")
    words = ("--backend", "kinematic", "--record", "tapes")
    assert test_main.cb(monkeypatch, "run", "look_ahead", *words) == 0

    def told() -> str:
        capsys.readouterr()
        assert cb(monkeypatch, "tapes") == 0
        return capsys.readouterr().out

    assert "changed" not in told()
    shared.write_text(SHARED.replace("effector: head}", "effector: head, gain: 3 /s}"), "utf-8")
    assert "look_ahead.yaml has changed since by shared document 'still'" in told()
    shared.unlink()
    assert "look_ahead.yaml has changed since, and has errors now" in told()
    program.unlink()
    assert "look_ahead.yaml is not there any more" in told()
