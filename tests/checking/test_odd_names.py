"""Odd names, which no file has: diagnostics that hide none of other documents."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.yaml_text.library import Library
from tests.cli.test_main import cb
from tests.conftest import ROOT

ODD = ("a" * 300, "a\0b", "x/" * 3000, "../" * 300 + "x", "\ud800", "a\nb", "/dev/zero")
DOCUMENTS = (
    "robots/panda.yaml",
    "programs/pick.yaml",
    "programs/stages/football.yaml",
    "knowledge/policies/reachtouch.yaml",
    "knowledge/schemas/reachtouch.yaml",
    *sorted(str(f.relative_to(ROOT)) for f in (ROOT / "knowledge" / "catalogs").glob("*.yaml"))[:1],
)
Steps = tuple[str | int, ...]


def texts(value: Any, steps: Steps = ()) -> Iterator[Steps]:
    """Yield the places of all texts."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from texts(inner, (*steps, key))
    elif isinstance(value, list):
        for place, inner in enumerate(value[:2]):
            yield from texts(inner, (*steps, place))
    elif isinstance(value, str):
        yield steps


def changed(data: Any, steps: Steps, text: str) -> bytes:
    """Return the document with another text in one place, as JSON."""
    copy = json.loads(json.dumps(data))
    inner = copy
    for step in steps[:-1]:
        inner = inner[step]
    inner[steps[-1]] = text
    return json.dumps(copy).encode()


@pytest.mark.parametrize("file", DOCUMENTS)
def test_check_document_with_an_odd_name_anywhere_reports_findings(file: str) -> None:
    data = yaml.safe_load((ROOT / file).read_text("utf-8"))
    path = (ROOT / file).with_name("odd.yaml")
    places = list(texts(data))
    # Every reference at the top, and some of the others.
    chosen = [steps for steps in places if len(steps) == 1 or steps[-1] in ("file", "model")]
    chosen += places[:: len(places) // 6 + 1]
    for number, steps in enumerate(chosen):
        for odd in ODD if len(steps) == 1 or steps[-1] == "file" else ODD[number % len(ODD) :][:1]:
            library = Library(ROOT, given={path: changed(data, steps, odd)})
            for diagnostic in check_document(path, Session(library, {})):
                assert diagnostic.message


@pytest.mark.parametrize("form", ["json", "sarif", "github", "text"])
@pytest.mark.parametrize("name", ODD[:4])
def test_validate_with_an_odd_name_reports_other_documents_too(
    name: str,
    form: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    head = {"cbdsl": 1, "kind": "program", "controllers": {}, "actions": [], "policy": {}}
    for file, robot in (("one", name), ("two", "absent")):
        Path(f"{file}.yaml").write_text(json.dumps({**head, "name": file, "robot": robot}))
    assert cb(monkeypatch, "validate", "--format", form, ".") == 1
    told = capsys.readouterr().out
    assert "one.yaml" in told and "two.yaml" in told and "absent" in told
