"""Output of C code, kept out of the standard output that belongs to ``print``."""

from __future__ import annotations

import ctypes
import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO, cast

from cbdsl.cli.process.legible_output import LegibleStream


@contextmanager
def shown_on_failure() -> Iterator[None]:
    """Keep the output of C code out of the standard output, which belongs to ``print``.

    If an exception is raised, the output goes to the standard error, because it may say why.
    """
    with tempfile.TemporaryFile() as captured, _stdout_of_c(captured.fileno()):
        try:
            yield
        # An interrupt is not among these: its reason is known.
        except Exception:
            _flush_c()
            captured.seek(0)
            text = captured.read().decode(errors="replace").rstrip()
            sys.stderr.write(f"{text}\n" if text else "")
            raise


@contextmanager
def _stdout_of_c(target: int) -> Iterator[None]:
    """Redirect C's standard output to a file; Python's keeps its previous target."""
    before = sys.stdout
    if before is None:  # closed by the caller
        yield
        return
    before.flush()
    # Libraries in C write to descriptor 1, regardless of `sys.stdout`. This descriptor leads to the
    # file for a while, and Python's stream gets a copy of the previous one.
    kept = os.dup(1)
    # A stream in memory, as in tests, does not use descriptor 1 and stays.
    if _descriptor(before) == 1:
        direct = os.fdopen(kept, "w", encoding=before.encoding, errors=before.errors, closefd=False)
        sys.stdout = cast(TextIO, LegibleStream(direct))
    os.dup2(target, 1)
    try:
        yield
        sys.stdout.flush()
    finally:
        # Text in the buffers of C would otherwise appear on the restored output.
        _flush_c()
        os.dup2(kept, 1)
        sys.stdout = before
        os.close(kept)


def _descriptor(stream: object) -> int | None:
    """Return the descriptor of a stream, or ``None`` for a stream in memory."""
    try:
        return int(stream.fileno())  # type: ignore[attr-defined]
    except (AttributeError, OSError):
        return None


def _flush_c() -> None:
    # For a null pointer, C flushes all of its output streams.
    ctypes.CDLL(None).fflush(None)
