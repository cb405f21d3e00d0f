"""Machine code of compiled functions, kept for all environments of one user."""

from __future__ import annotations

import hashlib
import os
import pickle
import stat
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any
from uuid import uuid4

import llvmlite
import numba
import numpy as np
from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

from cbdsl.numeric.kernel_claim import claim, release
from cbdsl.numeric.kernel_digest import NoDigestError, describe_type, digest_of
from cbdsl.numeric.numba_settings import import_arrays_of_numba

# Time without use after which a file is deleted, s.
_UNUSED = 60 * 24 * 3600.0
# Smallest interval between updates of a file's time of use, s.
_NOTED = 24 * 3600.0


class KernelCache(_Cache):
    """Machine code of one function, one file for each of its signatures.

    A file is named after all that its content depends on: the function and its callees, versions
    of the libraries, processor and signature. Hence environments and versions of cbdsl share one
    folder, an edit of any callee takes effect, and no file is ever changed.

    Args:
        function: Python function that is compiled.
        options: Options of its compilation.
    """

    def __init__(self, function: FunctionType, options: str) -> None:
        self._function, self._options = function, options

    @property
    def cache_path(self) -> str:
        """Folder of the files."""
        return str(folder() or "")

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the kept machine code of a signature, or ``None``."""
        import_arrays_of_numba()
        target_context.refresh()
        file = self._file(sig, target_context.codegen())
        if file is None:
            return None
        if (kept := self._load(file, target_context)) is None and problem() is None:
            claim(file)
            # Meanwhile another process may have compiled it.
            if (kept := self._load(file, target_context)) is not None:
                release(file)
        return kept

    def load_others(self, loaded: Iterable[Any], target_context: Any) -> Iterator[Any]:
        """Yield the kept machine code of each signature that is not loaded."""
        import_arrays_of_numba()
        target_context.refresh()
        codegen = target_context.codegen()
        known = {self._file(sig, codegen) for sig in loaded}
        for file in self._kept(codegen):
            if file in known:
                continue
            if (result := self._load(file, target_context)) is not None:
                yield result

    def _load(self, file: Path, target_context: Any) -> Any:
        """Return the machine code in a file; ``None`` if it cannot be used."""
        try:
            if not _is_own(file):
                return None
            parts = pickle.loads(file.read_bytes())
            _note_use(file)
            return CompileResult._rebuild(target_context, *parts)
        # If a file is invalid for any reason, its content can be compiled again.
        except Exception:
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep the machine code of a signature, unless it depends on this process."""
        file = self._file(sig, data.codegen)
        if file is None or problem() is not None:
            return
        depends = data.library.has_dynamic_globals or any(not e.can_cache for e in data.lifted)
        if not depends:
            _write(file, dumps(data._reduce()))
        release(file)

    def enable(self) -> None:
        """Do nothing: it is always enabled."""

    def disable(self) -> None:
        """Do nothing: it is always enabled."""

    def flush(self) -> None:
        """Do nothing: files are named after their content."""

    def is_kept(self, codegen: Any) -> bool:
        """Return whether the machine code of any signature is kept."""
        return any(self._kept(codegen))

    def _kept(self, codegen: Any) -> Iterator[Path]:
        """Yield the files of all signatures."""
        place, digest = folder(), self._digest(codegen)
        if place is not None and digest is not None:
            yield from place.glob(f"*-{digest}-*.nbc")

    def _file(self, sig: Any, codegen: Any) -> Path | None:
        place, digest = folder(), self._digest(codegen)
        if place is None or digest is None:
            return None
        kinds = getattr(sig, "args", sig)
        signature = _hash("\n".join(map(describe_type, kinds)))
        return place / f"{self._function.__qualname__}-{digest}-{signature}.nbc"

    def _digest(self, codegen: Any) -> str | None:
        try:
            own = digest_of(self._function, self._options)
        except NoDigestError:
            return None
        return _hash(f"{own} {codegen.magic_tuple()} {_surroundings()}")


def _is_own(file: Path) -> bool:
    """Return whether no other user can have written a file, because reading it runs its code."""
    return not any(_is_writable_by_others(each) for each in (file, file.parent))


def _is_writable_by_others(path: Path) -> bool:
    status = path.stat()
    others = stat.S_IWOTH | stat.S_IWGRP
    return status.st_uid not in (os.geteuid(), 0) or bool(status.st_mode & others)


def folder() -> Path | None:
    """Return the folder of the user's machine code, or ``None`` if the user has no home.

    It is NUMBA_CACHE_DIR if that is set, else a folder in the user's cache folder.
    """
    given = os.environ.get("NUMBA_CACHE_DIR")
    if given:
        return Path(given).absolute()
    caches, home = os.environ.get("XDG_CACHE_HOME", ""), os.path.expanduser("~")
    if os.path.isabs(caches):
        return Path(caches, "cbdsl", "kernels")
    has_home = os.path.isabs(home) and home != "/"
    return Path(home, ".cache", "cbdsl", "kernels") if has_home else None


def kept_files() -> int:
    """Return the number of files with machine code."""
    place = folder()
    return 0 if place is None else len([*place.glob("*.nbc")])


_problems: list[str] = []


def problem() -> str | None:
    """Return the reason why machine code could not be kept, if there is one."""
    place = folder()
    if place is None:
        return "the user has no home folder"
    if place.exists() and _is_writable_by_others(place):
        return f"{place}: other users can write to this folder"
    return _problems[0] if _problems else None


def _write(file: Path, content: bytes) -> None:
    """Write a file in one step, and delete files that are no longer used."""
    unfinished = file.with_suffix(f".{uuid4().hex[:16]}")
    try:
        with _removed_on_failure(unfinished):
            file.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            handle = os.open(unfinished, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
            with os.fdopen(handle, "wb") as stream:
                stream.write(content)
            unfinished.replace(file)
        _delete_unused(file.parent)
    except OSError as error:
        _problems.append(f"{file.parent}: {error.strerror or error}")


@contextmanager
def _removed_on_failure(file: Path) -> Iterator[None]:
    try:
        yield
    except BaseException:
        with suppress(OSError):
            file.unlink()
        raise


@cache
def _delete_unused(place: Path) -> None:
    """Delete files that were not used for long, once in a process."""
    oldest = time.time() - _UNUSED
    for file in place.iterdir():
        with suppress(OSError):
            if file.stat().st_mtime < oldest:
                file.unlink()


def _note_use(file: Path) -> None:
    """Set a file's time, by which unused files are deleted."""
    with suppress(OSError):
        if file.stat().st_mtime < time.time() - _NOTED:
            os.utime(file)


@cache
def _surroundings() -> str:
    """Describe versions and settings that machine code depends on."""
    versions = (sys.version_info[:2], sys.implementation.cache_tag, getattr(sys, "abiflags", ""))
    libraries = (numba.__version__, llvmlite.__version__, np.__version__)
    settings = sorted(
        f"{name}={value}"
        for name, value in os.environ.items()
        if name.startswith("NUMBA_") and name != "NUMBA_CACHE_DIR"
    )
    return f"{versions} {libraries} {settings}"


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:24]
