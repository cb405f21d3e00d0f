"""Files that commands keep and read again: journals and recordings."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from cbdsl.diagnostics.errors import UsageError
from cbdsl.learning.experience import EPISODES
from cbdsl.reporting.page import page
from cbdsl.reporting.recorded import read_recording
from cbdsl.storage.journal import JournalError, require_same, rows_of
from cbdsl.training.exploration.exploration_phases import open_journal
from tests.fuzz.entry_point import EntryPoint
from tests.fuzz.scratch import scratch

#: Three ticks of a recorded episode.
RECORDING = Path(__file__).parent / "recording" / "episode_25.json"
_FILE = Path("any.jsonl")
_IDENTITY = {"program": {"name": "reach", "sha256": "0"}, "seed": 1, "versions": {"numpy": "2"}}
_EXPLORATION: dict[str, Any] = {
    "programs": {"reach": {"name": "reach", "sha256": "0"}}, "policies": {},
    "stage": {"name": "table", "sha256": "1"}, "seed": 1,
}  # fmt: skip
_EPISODE = {
    "context": "near", "seed": 3, "rewarded": {"arm": [0.1, 0.2]}, "ticks": 9, "sim_seconds": 0.5,
    "wall_seconds": 0.1, "transitions": [
        {"program": "reach", "depth": 0, "time": 0.0, "state": "XX", "action": "go",
         "next_state": "0X", "reward": 0.0, "rewarding": []}],
}  # fmt: skip
_ACTION = {
    "action": "reach", "rewarded": True, "features": {"place": [0.1, 0.2, 0.3]}, "opened": [],
    "ahead": {"reach": {"seen": [], "place": [0.1, 0.2, 0.3]}}, "ending": "", "failed": False,
    "sim_seconds": 1.0, "wall_seconds": 0.1,
}  # fmt: skip


def _journal(data: bytes) -> None:
    try:
        rows, _ = rows_of(data, _FILE)
        for line, row in enumerate(rows[1:], 2):
            EPISODES.parse(row, _FILE, line)
        for row in rows[:1]:
            require_same(_FILE, row, _IDENTITY)
    except JournalError as error:
        assert "any.jsonl" in str(error)


def _exploration_journal(data: bytes) -> None:
    """Read a journal that begins with the bytes, and one with a valid head before them."""
    for head in (b"", _lines(_EXPLORATION)):
        file = _copy().with_suffix(".actions.jsonl")
        file.write_bytes(head + data)
        try:
            open_journal(file, _EXPLORATION, joins=True).close()
        except JournalError as error:
            assert file.name in str(error)


@cache
def _copy() -> Path:
    """Return a copy of the recording in a folder where it may be overwritten."""
    for suffix in (".json", ".npz"):
        shutil.copy(RECORDING.with_suffix(suffix), scratch())
    return scratch() / RECORDING.name


def _replay(suffix: str, data: bytes) -> None:
    """Replay a recording one of whose files holds other bytes."""
    file = _copy().with_suffix(suffix)
    file.write_bytes(data)
    try:
        page(read_recording(_copy()))
    except UsageError as error:
        assert RECORDING.stem in str(error)
    finally:
        shutil.copy(RECORDING.with_suffix(suffix), file)


def _lines(*rows: object) -> bytes:
    return "".join(json.dumps(row) + "\n" for row in rows).encode()


def _journals() -> Iterator[bytes]:
    yield from (_lines(_IDENTITY, _EPISODE, _EPISODE), _lines({"seed": 2}), b"\n", b"{}\n[]\n")


def _exploration_journals() -> Iterator[bytes]:
    joined = {**_EXPLORATION, "programs": {**_EXPLORATION["programs"], "lift": {"name": "lift"}}}
    yield from (_lines(_EXPLORATION, _ACTION), _lines({**_ACTION, "action": "noop"}))
    yield from (_lines(_ACTION, {"joined": joined}, _ACTION), _lines({"joined": 5}), b"{}\n")


ENTRY_POINTS = {
    "journal": EntryPoint(_journal, _journals),
    "exploration_journal": EntryPoint(_exploration_journal, _exploration_journals),
    "recording": EntryPoint(
        lambda data: _replay(".json", data), lambda: iter([RECORDING.read_bytes()])
    ),
    "arrays": EntryPoint(
        lambda data: _replay(".npz", data),
        lambda: iter([RECORDING.with_suffix(".npz").read_bytes()]),
    ),
}
