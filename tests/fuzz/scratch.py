"""Folder of the files that entry points write before they read them."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from functools import cache
from pathlib import Path

#: Folder in memory of Linux. A file that is created on a disk takes several times its reading.
_MEMORY = Path("/dev/shm")


@cache
def scratch() -> Path:
    """Return an empty folder of this process, in memory where the system has such a folder."""
    folder = tempfile.mkdtemp(prefix="fuzz", dir=_MEMORY if _MEMORY.is_dir() else None)
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)
