"""Locks of files: a second process waits, and then is refused."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

from cbdsl.storage.file_lock import LockedError, lock


def test_lock_waits_as_long_as_requested(tmp_path: Path) -> None:
    path = tmp_path / "some.jsonl"
    path.touch()
    first, second = path.open("rb"), path.open("rb")
    lock(first)
    with pytest.raises(LockedError):
        lock(second, 0.2)
    threading.Timer(0.3, first.close).start()
    lock(second, 60.0)
    second.close()
