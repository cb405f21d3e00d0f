"""Contents of files that other people name: regular files only, up to a size."""

from __future__ import annotations

import errno
import json
import os
import stat
from pathlib import Path
from typing import Any

#: Words for the kinds of files that are not regular.
KINDS = {
    stat.S_IFIFO: "a named pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
    stat.S_IFDIR: "a folder",
}


def contents(path: Path, most: int) -> bytes:
    """Return the bytes of a file.

    Pipes and devices are not opened, because reading them may block or never end.

    Args:
        path: Path of the file.
        most: Maximum number of bytes.

    Raises:
        OSError: The file does not exist, is not a regular file, or cannot be read; ``EFBIG`` if it
            has more bytes.
    """
    try:
        status = path.stat()
    except ValueError:  # as documents can name files
        raise OSError(errno.EINVAL, "its name has a character that no file name has") from None
    except FileNotFoundError:
        if path.is_symlink():
            raise FileNotFoundError(
                errno.ENOENT, f"it is a link to {os.readlink(path)}, which is not there", str(path)
            ) from None
        raise
    # ``stat`` follows links, so that a link to a device or a pipe is refused as well.
    if not stat.S_ISREG(status.st_mode):
        kind = KINDS.get(stat.S_IFMT(status.st_mode), "no file")
        raise OSError(errno.EINVAL, f"it is {kind}", str(path))
    if status.st_size <= most:
        with path.open("rb") as file:
            data = file.read(most + 1)  # it may have grown since, or say nothing of its size
        if len(data) <= most:
            return data
    raise OSError(errno.EFBIG, f"it is larger than {most} bytes", str(path))


def json_of(data: bytes) -> Any:
    """Return JSON data, with question marks for lone surrogates, which no file or page can hold.

    Raises:
        ValueError: The data is not JSON.
        RecursionError: It is nested too deeply.
    """
    value = json.loads(data)
    if b"\\ud" not in data.lower():
        return value
    return json.loads(json.dumps(value, ensure_ascii=False).encode("utf-8", "replace"))


def is_file(path: Path) -> bool:
    """Return whether a name from a document is that of a file; false for impossible names."""
    try:
        return path.is_file()
    except (OSError, ValueError):  # too long, or in a folder that may not be searched
        return False


def is_folder(path: Path) -> bool:
    """Return whether a name from a document is that of a folder; see ``is_file``."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False
