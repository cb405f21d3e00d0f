"""Standard streams that the caller has closed, as with ``>&-`` in a shell or in a daemon."""

from __future__ import annotations

import os
import sys


def fill_closed_streams() -> None:
    """Let closed streams lead nowhere.

    The next file that a command opens would have the number of a closed stream. The output of
    libraries in C would then be written into that file.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest free number
    if sys.stdout is None:
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 (open until the end)
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115


def read_standard_input(most: int) -> bytes:
    """Read the standard input to its end, or up to a size.

    Args:
        most: Number of bytes.

    Raises:
        UsageError: It is closed.
    """
    from cbdsl.diagnostics.errors import UsageError

    if sys.stdin is None:
        raise UsageError("the standard input is closed; name a file instead of '-'")
    return sys.stdin.buffer.read(most)
