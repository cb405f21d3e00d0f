"""Every code has an explanation, and an example that really has the fault."""

from __future__ import annotations

import re
import string
from pathlib import Path
from typing import cast

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.program import check_program
from cbdsl.checking.rules.reward import check_rewarded
from cbdsl.checking.safety_net import check_safely
from cbdsl.checking.session import Session
from cbdsl.checking.suppression import apply_suppressions
from cbdsl.diagnostics.catalogue import catalogue, hundred
from cbdsl.diagnostics.diagnostic import FAILED_CHECK, Diagnostic
from cbdsl.diagnostics.entry import Entry
from cbdsl.documents.kinds import entries
from cbdsl.robot.driver_kind import DRIVERS
from cbdsl.yaml_text.library import Library

ENTRIES = entries()
SOURCES = Path(__file__).resolve().parents[2] / "cbdsl"


def diagnostics(entry: Entry, example: str | bytes | None, folder: Path) -> list[Diagnostic]:
    """Return the diagnostics in one of an entry's examples."""
    for name, text in entry.beside.items():
        beside = folder / name
        beside.parent.mkdir(parents=True, exist_ok=True)
        beside.write_bytes(text if isinstance(text, bytes) else text.encode("utf-8"))
    path = folder / entry.path
    path.parent.mkdir(parents=True, exist_ok=True)
    if example is not None:
        path.write_bytes(example if isinstance(example, bytes) else example.encode("utf-8"))
    library = Library(folder)
    if entry.code == "CB324":  # an installation without the extra ros2
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(DRIVERS, "_offers", {})
            return check_document(path, session=Session(library))
    if entry.code == FAILED_CHECK and example is None:  # no document by itself causes it
        return check_safely(path, cast(Session, "a session without a library"))
    found = check_document(path, session=Session(library))
    if entry.code == "CB720":  # which matters only to learners and is reported by cb learn
        found = [*found, *check_rewarded(check_program(path, library=library), path, library)]
    return apply_suppressions(found, [path], library)


@pytest.mark.parametrize("entry", ENTRIES.values(), ids=ENTRIES)
def test_bad_example_has_exactly_this_fault(entry: Entry, tmp_path: Path) -> None:
    (found,) = diagnostics(entry, entry.bad, tmp_path)
    assert (found.code, found.severity) == (entry.code, entry.severity)


@pytest.mark.parametrize("entry", ENTRIES.values(), ids=ENTRIES)
def test_good_example_has_no_fault(entry: Entry, tmp_path: Path) -> None:
    assert diagnostics(entry, entry.good, tmp_path) == []


@pytest.mark.parametrize("entry", ENTRIES.values(), ids=ENTRIES)
def test_entry_is_complete(entry: Entry) -> None:
    assert re.fullmatch(r"CB\d{3}" if entry.code in catalogue() else r"[A-Z]+\d+", entry.code)
    assert entry.code not in catalogue() or hundred(entry.code)[entry.code] is entry
    assert entry.title and entry.explanation.endswith(".")
    assert not entry.message.endswith(".")
    assert not entry.title[0].isupper() or entry.title.split()[0].isupper()
    assert all(name != "" for _, name, _, _ in string.Formatter().parse(entry.message))


def test_every_code_in_the_sources_is_in_the_catalogue_and_back() -> None:
    used = {
        code
        for path in SOURCES.rglob("*.py")
        for code in re.findall(r'"(CB\d{3})"', path.read_text(encoding="utf-8"))
    }
    assert used == set(catalogue())
