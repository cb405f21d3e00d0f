"""Atomic writes of files, so that no reader sees a partial file."""

from __future__ import annotations

import errno
import os
import secrets
import stat
import tempfile
from collections.abc import Callable
from contextlib import suppress
from glob import escape
from pathlib import Path
from typing import BinaryIO

from cbdsl.diagnostics.legible_text import encoded


# A name that the user gave is followed through links. A name that was derived from it, or found in
# a folder, may be a link that another author left there, and leads anywhere: it is refused.
def make_room(path: Path, *, follow: bool = False) -> None:
    """Create the folder of a file, and check that the file can be written later.

    Args:
        path: Path of the file.
        follow: True if a symbolic link is followed, because the user gave the path.

    Raises:
        OSError: The folder cannot be created or written to.
    """
    _require_replaceable(path, follow)
    folder = _target(path).parent
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile(dir=folder):
        pass


def write_text(text: str, path: Path, *, follow: bool = False) -> None:
    """Write a file atomically; see ``replace_file``."""
    write_bytes(encoded(text), path, follow=follow)


def write_bytes(contents: bytes, path: Path, *, follow: bool = False) -> None:
    """Write a file atomically; see ``replace_file``."""
    replace_file(path, lambda file: file.write(contents), follow=follow)


def replace_file(path: Path, fill: Callable[[BinaryIO], object], *, follow: bool = False) -> None:
    """Write a file atomically, so that no reader sees a partial file.

    An existing file keeps its permissions, and a followed symbolic link stays a link.

    Args:
        path: Path of the file.
        fill: Function that writes the contents.
        follow: True if a symbolic link is followed, because the user gave the path.

    Raises:
        OSError: The file cannot be written; the error names it.
    """
    _require_replaceable(path, follow)
    target = _target(path)
    try:
        _replace(target, fill)
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(path)) from error
    _sync_folder(target.parent)


# The contents go to a temporary file in the same folder, thus in the same file system. A rename
# there is atomic: a reader finds either the old or the new file. The contents are flushed to disk
# before the rename, and the folder's entry after it. After a loss of power the file is therefore
# also one of the two.
def _replace(path: Path, fill: Callable[[BinaryIO], object]) -> None:
    temporary = path.parent / f"{_prefix(path)}{secrets.token_hex(8)}"
    # The system creates a new file with the permissions that the user's mask leaves.
    handle = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
    try:
        with os.fdopen(handle, "wb") as file:
            with suppress(FileNotFoundError):
                os.fchmod(file.fileno(), stat.S_IMODE(path.stat().st_mode))
            fill(file)
            file.flush()
            os.fsync(file.fileno())  # before the rename replaces the old contents
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise


def _target(path: Path) -> Path:
    """Return the file behind symbolic links, which a rename would replace."""
    return Path(os.path.realpath(path)) if path.is_symlink() else path


def _sync_folder(folder: Path) -> None:
    """Flush the entries of a folder to disk, if its file system supports this."""
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def require_unlinked(path: Path) -> None:
    """Refuse a symbolic link in the place of a file or folder that the user has not named.

    Raises:
        OSError: The path is a symbolic link.
    """
    if path.is_symlink():
        problem = (
            f"it is a link to {os.readlink(path)}, and links are followed for given names only"
        )
        raise OSError(errno.ELOOP, f"{problem}; remove the link", str(path))


def _require_replaceable(path: Path, follow: bool) -> None:
    """Refuse a folder, and a device such as /dev/null, which a rename would replace.

    Raises:
        OSError: The path exists and is not a file, or is a link that is not followed.
    """
    if not follow:
        require_unlinked(path)
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if path.exists() and not path.is_file():
        raise OSError(errno.EINVAL, "this is a device, not a file", str(path))


def remove_leftovers(path: Path) -> None:
    """Remove the temporary files of processes that were killed while they wrote a file.

    The caller must ensure that no process is writing the file.

    Raises:
        OSError: A temporary file cannot be removed.
    """
    target = _target(path)
    for leftover in target.parent.glob(f"{escape(_prefix(target))}*"):
        leftover.unlink()


def _prefix(path: Path) -> str:
    return f".{path.name}.unfinished-"
