"""The signal by which batch systems and shells end a command."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def termination_interrupts() -> Iterator[None]:
    """Let SIGTERM end a command as Ctrl-C does, with a clean terminal and ended workers.

    Raises:
        KeyboardInterrupt: The signal was received.
    """
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


@contextmanager
def stop_requests() -> Iterator[Callable[[], bool]]:
    """Note Ctrl-C and SIGTERM, for loops that end by themselves.

    Yields:
        Function that returns whether one of them came.
    """
    # The handlers raise nothing. An exception at an arbitrary place could leave a message to a
    # robot incomplete.
    came: list[int] = []
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(number, lambda n, _: came.append(n)) for number in numbers]
    try:
        yield lambda: bool(came)
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)
