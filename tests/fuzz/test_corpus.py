"""Inputs that fuzzers and people found are read without a fault on each run.

The corpus holds the inputs that ``make fuzz`` kept, with all inputs that were faults. It needs
no fuzzer; to search for more does (extra ``fuzz``).
"""

from __future__ import annotations

import subprocess
import sys
from importlib.util import find_spec
from itertools import islice

import pytest

from cbdsl.documents.kinds import KINDS
from tests.conftest import ROOT
from tests.fuzz.corpus import FOLDER, kept
from tests.fuzz.entry_point import MODULES, EntryPoint, entry_point

#: Seeds that are read in the fast test; the others are documents that other tests read.
FEW = 12


@pytest.mark.parametrize("name", MODULES)
def test_entry_point_reads_its_corpus(name: str) -> None:
    found = entry_point(name)
    seeds = list(islice(found.seeds(), FEW))
    assert seeds, "a fuzzer needs something to begin with"
    for each in (*seeds, *kept(name)):
        found.read(each)


def test_every_corpus_has_an_entry_point() -> None:
    assert {file.stem for file in FOLDER.glob("*.jsonl")} <= set(MODULES)


def test_every_kind_of_document_is_an_entry_point() -> None:
    assert set(KINDS.builtins) <= set(MODULES)


def test_algebra_of_patterns_is_held_to_sets(monkeypatch: pytest.MonkeyPatch) -> None:
    """Notice a wrong reader: patterns are compared with the sets of their states."""
    from tests.fuzz import language

    monkeypatch.setattr(language, "overlap", lambda one, other: one)
    with pytest.raises(AssertionError):
        entry_point("pattern").read(b"X0*\n*01")


@pytest.mark.slow
@pytest.mark.skipif(find_spec("atheris") is None, reason="atheris is not installed (extra fuzz)")
def test_fuzzer_finds_a_fault_by_its_branches() -> None:
    """Find three letters in a row, the first of which only coverage reveals."""
    script = (
        "import sys, atheris\n"
        "@atheris.instrument_func\n"
        "def read(data):\n"
        "    if data[:1] == b'Q':\n"
        "        if data[1:2] == b'Z':\n"
        "            if data[2:3] == b'!':\n"
        "                raise ValueError('found')\n"
        "atheris.Setup(sys.argv, read)\n"
        "atheris.Fuzz()\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, "-runs=2000000", "-seed=1", "-artifact_prefix=/dev/null"],
        cwd=ROOT, capture_output=True, timeout=300,
    )  # fmt: skip
    assert b"ValueError: found" in done.stdout + done.stderr


def test_entry_points_are_distinguished() -> None:
    assert all(isinstance(entry_point(name), EntryPoint) for name in MODULES)
