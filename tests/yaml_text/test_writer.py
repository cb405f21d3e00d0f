"""Written documents, which are read back unchanged."""

from __future__ import annotations

import stat
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cbdsl.documents.kinds import KINDS as ALL
from cbdsl.documents.kinds import models
from cbdsl.yaml_text.library import shipped
from cbdsl.yaml_text.reader import read_document
from cbdsl.yaml_text.writer import dump, write
from tests.yaml_text.documents import DOCUMENTS

#: Models of all kinds but those of other packages.
KINDS = {name: model for name, model in models().items() if ALL.is_builtin(name)}

SHIPPED = sorted(
    p for folder in ("robots", "programs") for p in (shipped() / folder).rglob("*.yaml")
)


def test_writer_tests_cover_every_kind() -> None:
    assert set(DOCUMENTS) == set(KINDS)


@pytest.mark.parametrize("kind", DOCUMENTS)
@settings(
    max_examples=60,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(data=st.data())
def test_load_after_dump_is_the_identity(kind: str, data: st.DataObject, tmp_path: Path) -> None:
    document = data.draw(DOCUMENTS[kind])
    path = tmp_path / "document.yaml"
    write(document, path)
    again = read_document(path).document
    assert again == document
    assert dump(again) == dump(document)


@pytest.mark.parametrize(
    "text", ["<<", "=", "~", "", "no", "012", "1:30", "0x1", "---", "?", "- a"]
)
def test_text_with_a_meaning_in_yaml_survives_as_key_and_value(text: str, tmp_path: Path) -> None:
    document = KINDS["program"].model_validate(
        {
            "cbdsl": 1, "kind": "program", "name": "a", "robot": "a", "controllers": {},
            "actions": [text], "policy": {text: text},
        }
    )  # fmt: skip
    write(document, tmp_path / "a.yaml")
    assert read_document(tmp_path / "a.yaml").document == document


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_documents_survive(path: Path, tmp_path: Path) -> None:
    document = read_document(path).document
    write(document, tmp_path / path.name)
    assert read_document(tmp_path / path.name).document == document


@pytest.mark.parametrize("unseen", "\u200b\u200e\u202a\u202e\u2060\u2066\ufeff", ids=ascii)
@pytest.mark.parametrize("text", ["{}", "a{}b", "\\{}", "'{}\"", "{}: {}"])
def test_mutant_that_no_test_notices_survives(text: str, unseen: str, tmp_path: Path) -> None:
    description = text.replace("{}", unseen)
    document = read_document(SHIPPED[0]).document.model_copy(update={"description": description})
    write(document, tmp_path / "a.yaml")
    assert read_document(tmp_path / "a.yaml").document == document


def test_writing_leaves_one_readable_file(tmp_path: Path) -> None:
    document = read_document(SHIPPED[0]).document
    write(document, tmp_path / "a.yaml")
    write(document, tmp_path / "a.yaml")
    assert [path.name for path in tmp_path.iterdir()] == ["a.yaml"]
    assert (tmp_path / "a.yaml").stat().st_mode & stat.S_IROTH


def test_failing_to_write_leaves_the_old_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    document = read_document(SHIPPED[0]).document
    path = tmp_path / "a.yaml"
    path.write_text("old")

    def fail(*_: object) -> str:
        raise OSError("disk full")

    monkeypatch.setattr("cbdsl.yaml_text.writer.dump", fail)
    with pytest.raises(OSError, match="disk full"):
        write(document, path)
    assert [p.name for p in tmp_path.iterdir()] == ["a.yaml"] and path.read_text() == "old"
