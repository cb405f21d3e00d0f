"""Contract of kinds of documents: their schemas, and the examples of their diagnostics."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostic import Diagnostic
from cbdsl.diagnostics.entry import Entry
from cbdsl.documents.json_schema import properties
from cbdsl.documents.kinds import KINDS
from cbdsl.yaml_text.library import Library

ENTRIES = {
    entry.code: entry
    for name in KINDS.usable_names()
    if not KINDS.is_builtin(name)
    for entry in KINDS.get(name).entries
}
ENTRY = pytest.mark.parametrize("entry", ENTRIES.values(), ids=ENTRIES)


def _diagnostics(entry: Entry, text: str, folder: Path) -> list[Diagnostic]:
    """Return the diagnostics of an example in a folder."""
    for name, other in {**entry.beside, entry.path: text}.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(other.encode() if isinstance(other, str) else other)
    return check_document(folder / entry.path, session=Session(Library(folder)))


@pytest.mark.parametrize("name", KINDS.usable_names())
def test_keys_of_a_kind_have_meanings(name: str) -> None:
    keys = properties(KINDS.get(name).model)
    assert [key for key, value in keys.items() if not value.get("description")] == []


@ENTRY
def test_bad_example_has_exactly_its_diagnostic(entry: Entry, tmp_path: Path) -> None:
    assert isinstance(entry.bad, str)
    (diagnostic,) = _diagnostics(entry, entry.bad, tmp_path)
    assert (diagnostic.code, diagnostic.severity) == (entry.code, entry.severity)


@ENTRY
def test_good_example_has_no_diagnostic(entry: Entry, tmp_path: Path) -> None:
    assert _diagnostics(entry, entry.good, tmp_path) == []
