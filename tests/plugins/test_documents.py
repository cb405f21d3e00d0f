"""A kind of document of another package: read, checked, described and listed like the others."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from cbdsl.documents.kinds import KINDS
from docs.make_reference import page
from tests.cli.test_main import cb
from tests.plugins.installed import write_package

GOOD = "cbdsl: 1\nkind: playlist\nname: evening\nrobot: dexter\nprograms: [posture, reach]\n"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "playlists").mkdir()
    (tmp_path / "playlists" / "evening.yaml").write_text(GOOD)
    return tmp_path


def test_plugin_document_is_found_by_name_without_diagnostics(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "validate", "evening") == 0
    assert "1 document, no findings" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("old", "new", "wanted"),
    [
        ("[posture, reach]", "[posture, reech]", "CB604.*reech"),
        ("[posture, reach]", "[posture, posture]", "DEMO101.*'posture' follows itself"),
        ("dexter", "dextre", "CB601.*dextre.*dexter"),
        ("robot: dexter\n", "", "CB203.*robot"),
        ("programs:", "program:", "CB202.*program.*programs"),
        ("reach]", "reach]\npause: 3 cm", "CB20.*cm"),
        ("[posture, reach]", "[posture]\nafter: morning", "DEMO100.*morning.*evening"),
        ("kind: playlist", "kind: playlst", "CB206.*playlst.*policy, model, .*playlist"),
        ("name: evening", "name: morning", "CB704.*morning"),
    ],
)
def test_faults_are_reported_like_those_of_other_documents(
    old: str,
    new: str,
    wanted: str,
    here: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (here / "playlists" / "evening.yaml").write_text(GOOD.replace(old, new))
    assert cb(monkeypatch, "validate", "playlists") == (0 if "CB704" in wanted else 1)
    out = capsys.readouterr().out
    assert re.search(wanted, out, re.DOTALL), out
    assert "1 error" in out or "1 warning" in out, out


def test_diagnostics_of_a_plugin_document_are_rules_of_sarif(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    twice = GOOD.replace("reach]", "posture]")
    (here / "playlists" / "evening.yaml").write_text(twice)
    cb(monkeypatch, "validate", "playlists", "--format", "sarif")
    (run,) = json.loads(capsys.readouterr().out)["runs"]
    assert [rule["id"] for rule in run["tool"]["driver"]["rules"]] == ["DEMO101"]


def test_plugin_document_has_a_json_schema(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "schema", "playlist") == 0
    pause = json.loads(capsys.readouterr().out)["properties"]["pause"]
    assert pause["description"].startswith("Time between one program and the next. Unit: ")
    assert cb(monkeypatch, "schema", "--write", "schemas") == 0
    written = {file.name.partition(".")[0] for file in (here / "schemas").glob("*.json")}
    assert written == {*KINDS.usable_names()} >= {"playlist", *KINDS.builtins}


def test_plugin_document_kind_is_listed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "show", "kinds", "--json") == 0
    shown = json.loads(capsys.readouterr().out)
    kind = {"kind of document": "playlist", "package": "demo 1.0", "folder": "playlists"}
    assert shown[-1] == kind


def test_diagnostics_of_a_plugin_document_are_explained(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "explain", "DEMO101") == 0
    assert "program twice in a row" in capsys.readouterr().out
    assert cb(monkeypatch, "explain", "--all", "--markdown") == 0
    assert "## DEMO101: program twice in a row" in capsys.readouterr().out


def test_reference_lists_keys_and_diagnostics_of_a_plugin_document() -> None:
    text = page()
    assert "### Kind playlist" in text
    assert "| `pause` | Time between one program and the next." in text
    assert "[DEMO101]" in text


FAULTY = """
from dataclasses import replace
from typing import Literal
from cbdsl.documents.kind import Kind
from demo.playlist import PLAYLIST
class Broken(PLAYLIST.model):
    kind: Literal["broken"]
def check(*_):
    1 / 0
"""


@pytest.mark.parametrize(
    ("record", "reason"),
    [
        ("3", "is int, not"),
        ("PLAYLIST", 'lacks kind: Literal["broken"]'),
        ("PLAYLIST._replace(model=int)", "not a subclass"),
        ("PLAYLIST._replace(model=Broken, references={'robot': 'robto'})", "not there: robto"),
        ("PLAYLIST._replace(model=Broken, references={'robots': 'robot'})", "references robots"),
        ("PLAYLIST._replace(model=Broken, folder='../x')", "folder ../x"),
        ("PLAYLIST._replace(model=Broken, checker='broken')", "'broken' is not module:function"),
        (
            "PLAYLIST._replace(model=Broken, entries=(replace(PLAYLIST.unknown, code='CB101'),))",
            "codes of the catalogue: CB101",
        ),
        ("Kind()", "TypeError"),
    ],
)
def test_broken_plugin_document_is_named_and_others_work(
    record: str,
    reason: str,
    here: Path,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    points = {KINDS.group: {"broken": "faulty:KIND"}}
    write_package(folder, "faulty", points, faulty=f"{FAULTY}KIND = {record}\n")
    KINDS.refresh()
    (here / "broken.yaml").write_text("cbdsl: 1\nkind: broken\nname: broken\n")
    assert cb(monkeypatch, "validate", "broken.yaml", "evening") == 1
    out, err = capsys.readouterr()
    assert "kind of document 'broken' (package faulty 1.0, group cbdsl.documents)" in err
    assert reason in err
    assert "CB206 unknown value 'broken'" in out and "1 error" in out
    assert cb(monkeypatch, "schema", "--write", "schemas") == 0
    assert reason in capsys.readouterr().err


def test_checker_that_fails_is_named_with_its_package(
    here: Path,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    text = f"{FAULTY}KIND = PLAYLIST._replace(checker='faulty:check', model=Broken)\n"
    write_package(folder, "faulty", {KINDS.group: {"broken": "faulty:KIND"}}, faulty=text)
    KINDS.refresh()
    (here / "broken.yaml").write_text(GOOD.replace("playlist", "broken"))
    assert cb(monkeypatch, "validate", "broken.yaml", "evening") == 2
    out = capsys.readouterr().out
    assert "broken.yaml" in out and "CB901" in out
    assert "package faulty 1.0" in out and "ZeroDivisionError" in out
