"""The signal by which batch systems and shells end a command."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def termination_interrupts() -> Iterator[None]:
    """Let SIGTERM end a command as Ctrl-C does: the terminal is left clean, workers are ended.

    Raises:
        KeyboardInterrupt: the signal came.
    """
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
