"""Links that another author left in a folder: no command writes through them."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cli.test_main import cb
from tests.reporting.conftest import Record, kept, play, record

__all__ = ["Record", "kept", "play", "record"]

UNFORMATTED = 'cbdsl:   1\nkind: stage\nname: mine\nrobot: "planr"\ncontexts: {only: {}}\n'

# Commands, with the names that they are given; all other names that they write are derived.
COMMANDS = {
    "replay": ("replay theirs/episode_0.json --no-open", ()),
    "replay of a folder": ("replay theirs --no-open", ()),
    "report": ("report theirs/learned.yaml --no-open", ()),
    "record": ("run searchtrack --backend kinematic --record theirs --overwrite", ()),
    "mcap": ("export mcap theirs/episode_0.json", ()),
    "learn": (
        "learn searchtrack --backend kinematic --episodes 1 --out theirs/policies/x.yaml",
        ("theirs/policies/x.yaml",),
    ),
    "learn trials": (
        "learn searchtrack --backend kinematic --episodes 1 --trials 2 --out theirs/x.yaml",
        (),
    ),
    "schema": ("schema stage --write theirs", ()),
    "new": ("new program theirs --to theirs --force", ()),
    "new in the folder of its kind": ("new program mine --force", ()),
}


@pytest.fixture
def theirs(kept: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder of another author, with a recording and a learned policy."""
    folder = tmp_path / "project" / "theirs"
    folder.mkdir(parents=True)
    for suffix in (".json", ".npz"):
        shutil.copy(kept.with_suffix(suffix), folder / f"episode_0{suffix}")
    shutil.copy(Path("knowledge/policies/searchtrack.yaml"), folder / "learned.yaml")
    monkeypatch.chdir(folder.parent)
    return folder


def written(folder: Path, command: Callable[[], object]) -> set[Path]:
    """Return the files that a command creates or changes below a folder."""

    def times() -> dict[Path, int]:
        return {each: each.stat().st_mtime_ns for each in folder.rglob("*") if each.is_file()}

    before = times()
    command()
    return {each for each, time in times().items() if before.get(each) != time}


@pytest.mark.parametrize("name", COMMANDS)
def test_no_command_writes_through_a_planted_link(
    name: str, theirs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    words, given = COMMANDS[name]
    project = theirs.parent
    pristine = tmp_path / "pristine"
    shutil.copytree(project, pristine)
    files = written(project, lambda: cb(monkeypatch, *words.split()))
    derived = {each.relative_to(project) for each in files} - set(map(Path, given))
    assert derived, "the command writes nothing"
    mine = tmp_path / "mine"
    folders = {each.parent for each in derived} - {Path(), Path("theirs"), Path("theirs/policies")}
    for file in sorted(derived | folders):
        shutil.rmtree(project)
        shutil.copytree(pristine, project)
        shutil.rmtree(mine, ignore_errors=True)
        mine.mkdir()
        victim = mine / "notes.txt"
        victim.write_text("of my own", encoding="utf-8")
        (project / file).parent.mkdir(parents=True, exist_ok=True)
        (project / file).unlink(missing_ok=True)
        (project / file).symlink_to(mine if file in folders else victim)
        cb(monkeypatch, *words.split(), *(["--resume"] if words.startswith("learn") else []))
        assert victim.read_text("utf-8") == "of my own", file
        assert os.listdir(mine) == ["notes.txt"], file


@pytest.mark.parametrize("words", ["fmt .", "fmt theirs", "validate . --fix"])
def test_command_for_a_folder_leaves_linked_files(
    words: str, theirs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    victim = tmp_path / "mine.yaml"
    victim.write_text(UNFORMATTED, encoding="utf-8")
    (theirs / "link.yaml").symlink_to(victim)
    cb(monkeypatch, *words.split())
    assert victim.read_text("utf-8") == UNFORMATTED


def test_fmt_follows_a_link_that_the_user_names(
    theirs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    victim = tmp_path / "mine.yaml"
    victim.write_text(UNFORMATTED, encoding="utf-8")
    link = theirs / "link.yaml"
    link.symlink_to(victim)
    assert cb(monkeypatch, "fmt", "theirs/link.yaml") == 0
    assert link.is_symlink() and victim.read_text("utf-8") != UNFORMATTED
