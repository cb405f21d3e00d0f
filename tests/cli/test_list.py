"""``cb list`` and shell completion."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from cbdsl.cli.commands import main_names
from cbdsl.documents.kinds import models
from cbdsl.yaml_text.library import Library, shipped
from tests.cli.test_main import cb


def test_every_document_that_has_a_name_here_is_listed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "programs").mkdir()
    (tmp_path / "programs" / "mine.yaml").write_text("kind: [", "utf-8")
    assert cb(monkeypatch, "list", "--json") == 0
    rows = json.loads(capsys.readouterr().out)
    library = Library(tmp_path)
    expected = {(kind, name) for kind, model in models().items() for name in library.names(model)}
    assert {(row["kind"], row["name"]) for row in rows} == expected
    (mine,) = (row for row in rows if row["name"] == "mine")
    assert mine["file"] == "programs/mine.yaml" and "cb validate" in mine["description"]
    (reach,) = (row for row in rows if row["name"] == "reachtouch" and row["kind"] == "program")
    assert reach["robot"] == "" and reach["description"]
    assert Path(reach["file"]) == shipped() / "programs" / "reachtouch.yaml"


@pytest.mark.parametrize("word", ["robot", "robots", "policies"])
def test_list_of_one_kind_contains_no_others(
    word: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "list", word, "--json") == 0
    kinds = {row["kind"] for row in json.loads(capsys.readouterr().out)}
    assert kinds == {"policy" if word == "policies" else "robot"}


def test_list_prints_a_table_and_refuses_an_unknown_kind_with_the_known_ones(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "list", "programs") == 0
    assert "searchtrack" in capsys.readouterr().out
    assert cb(monkeypatch, "list", "programz") == 2
    assert "did you mean 'programs'" in capsys.readouterr().err


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_shells_complete_commands_and_options(shell: str) -> None:
    def completed(*words: str) -> str:
        line = " ".join(("cb", *words))
        variables = {
            "_CB_COMPLETE": f"complete_{shell}",
            "COMP_WORDS": line,
            "COMP_CWORD": str(len(words)),
            "_TYPER_COMPLETE_ARGS": line,
            "_TYPER_COMPLETE_FISH_ACTION": "get-args",
        }
        script = "import sys; sys.argv[0] = 'cb'; from cbdsl.cli.main import main; main()"
        done = subprocess.run(
            [sys.executable, "-c", script],
            env={**os.environ, **variables},
            capture_output=True,
            text=True,
        )
        return done.stdout

    assert all(name in completed("") for name in main_names())
    assert "--record" in completed("run", "--rec")
    for words, name in (
        (("run", "reacht"), "reachtouch"),
        (("run", "reachtouch", "--stage", "table_r"), "table_right"),
        (("explain", "CB50"), "CB504"),
    ):
        assert name in completed(*words)
