"""Locks of files against other processes."""

from __future__ import annotations

import fcntl
import time
from typing import BinaryIO

# Pause between two attempts, s.
_PAUSE = 0.1


class LockedError(Exception):
    """Error of a file that another process has locked."""


def lock(file: BinaryIO, patience: float = 0.0) -> None:
    """Lock a file; the lock ends with the process, however that ends.

    Args:
        file: Open file.
        patience: Time to wait for another process, s.

    Raises:
        LockedError: If another process holds the lock for longer.
        OSError: If the file system does not support locks.
    """
    # A lock of this kind belongs to the open file. A lock by fcntl would be lost as soon as the
    # process closes any other descriptor of the file. The call has no time limit, so it is repeated
    # without blocking.
    deadline = time.monotonic() + patience
    while True:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except BlockingIOError as error:
            if time.monotonic() >= deadline:
                raise LockedError from error
        time.sleep(_PAUSE)
