"""``cb schema``: committed schemas match the models, and documents name their schema."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cbdsl.documents.json_schema import json_schema, json_text, schema_file
from cbdsl.documents.kinds import KINDS as ALL
from cbdsl.documents.kinds import models
from tests.cli.test_main import cb

#: Models of all kinds but those of other packages.
KINDS = {name: model for name, model in models().items() if ALL.is_builtin(name)}

ROOT = Path(__file__).parents[2]
SHIPPED = sorted(p for folder in ("robots", "programs") for p in (ROOT / folder).rglob("*.yaml"))
FIRST_LINE = "# yaml-language-server: $schema="


@pytest.mark.parametrize("kind", KINDS)
def test_committed_schemas_are_the_generated_ones(kind: str) -> None:
    committed = (ROOT / "schemas" / schema_file(kind)).read_text("utf-8")
    assert committed == json_text(json_schema(KINDS[kind])), "run: cb schema --write schemas"


def test_committed_schemas_are_those_of_the_known_kinds() -> None:
    files = {path.name for path in (ROOT / "schemas").glob("*.json")}
    assert files == {schema_file(kind) for kind in KINDS}


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_documents_name_their_schema(path: Path) -> None:
    first, *_ = path.read_text("utf-8").splitlines()
    assert first.startswith(FIRST_LINE)
    schema = json.loads((path.parent / first.removeprefix(FIRST_LINE)).read_text("utf-8"))
    assert f"kind: {schema['properties']['kind']['const']}\n" in path.read_text("utf-8")


def test_schemas_are_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "new" / "schemas"
    assert cb(monkeypatch, "schema", "--write", str(folder)) == 0
    for kind in KINDS:
        written = (folder / schema_file(kind)).read_text("utf-8")
        assert written == json_text(json_schema(KINDS[kind]))


def test_schema_prints_one_kind_or_all(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "schema", "stage") == 0
    stage = json.loads(capsys.readouterr().out)
    assert cb(monkeypatch, "schema") == 0
    schemas = json.loads(capsys.readouterr().out)
    assert list(schemas) == list(models()) and schemas["stage"] == stage


def test_wrong_calls_exit_with_2(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "schema", "robo") == 2
    assert "did you mean 'robot'?" in capsys.readouterr().err
    (tmp_path / "file").touch()
    assert cb(monkeypatch, "schema", "--write", str(tmp_path / "file" / "below")) == 2
    assert "Traceback" not in capsys.readouterr().err
