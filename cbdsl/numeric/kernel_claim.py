"""Claims on files of machine code, so that no two processes compile the same function."""

from __future__ import annotations

import fcntl
import os
import time
from contextlib import suppress
from pathlib import Path

# Time after which a function is compiled although another process still claims it, s, and the
# interval between looks at its claim, s.
_PATIENCE, _INTERVAL = 300.0, 0.02

_claims: dict[Path, int] = {}


def claim(file: Path) -> None:
    """Claim a file, after another process that claims it; the claim ends with this process.

    Waiting never forms a circle: a process waits for a function that its own functions call.

    Args:
        file: File that does not exist yet. Without a right to lock, nothing is claimed.
    """
    if file in _claims:
        return
    with suppress(OSError):
        file.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        lock = os.open(_lock(file), os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        _claims[file] = lock
        ends = time.monotonic() + _PATIENCE
        while not _locks(lock) and time.monotonic() < ends:
            time.sleep(_INTERVAL)


def release(file: Path) -> None:
    """End the claim on a file, if there is one."""
    if (lock := _claims.pop(file, None)) is not None:
        # A process that waits for this lock then looks for the file.
        with suppress(OSError):
            _lock(file).unlink()
        os.close(lock)


def _lock(file: Path) -> Path:
    return file.with_suffix(".lock")


def _locks(lock: int) -> bool:
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True
