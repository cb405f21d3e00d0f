"""Locks of journals: who waits, gets one as soon as it is free, and is told where it is not."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

from cbdsl.runtime.line_journal import JournalError, lock


def test_a_lock_is_waited_for_as_long_as_asked(tmp_path: Path) -> None:
    path = tmp_path / "some.jsonl"
    path.touch()
    first, second = path.open("rb"), path.open("rb")
    lock(first, path, 0.0)
    with pytest.raises(JournalError, match=r"another process is at work on .*some\.jsonl"):
        lock(second, path, 0.2)
    threading.Timer(0.3, first.close).start()
    lock(second, path, 60.0)
    second.close()
