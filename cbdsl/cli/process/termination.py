"""The signals by which batch systems, shells and closed terminals end a command."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

# A closed terminal or a lost connection sends SIGHUP, which Windows lacks.
_HANGUP = getattr(signal, "SIGHUP", None)
_ENDING = (signal.SIGTERM, *([] if _HANGUP is None else [_HANGUP]))


@contextmanager
def termination_interrupts() -> Iterator[None]:
    """Let SIGTERM and SIGHUP end a command as Ctrl-C does, with ended workers.

    Raises:
        KeyboardInterrupt: The signal was received.
    """
    with _handled(_ENDING, signal.default_int_handler):
        yield


@contextmanager
def stop_requests() -> Iterator[Callable[[], bool]]:
    """Note Ctrl-C, SIGTERM and SIGHUP, for loops that end by themselves.

    Yields:
        Function that returns whether one of them came.
    """
    # The handlers raise nothing. An exception at an arbitrary place could leave a message to a
    # robot incomplete.
    came: list[int] = []
    with _handled((signal.SIGINT, *_ENDING), lambda number, _: came.append(number)):
        yield lambda: bool(came)


@contextmanager
def _handled(numbers: Iterable[int], handler: Callable[[int, Any], object]) -> Iterator[None]:
    """Handle some signals, except for SIGHUP under ``nohup``, which ignores it."""
    kept = [n for n in numbers if signal.getsignal(n) is not signal.SIG_IGN or n != _HANGUP]
    before = [(number, signal.signal(number, handler)) for number in kept]
    try:
        yield
    finally:
        for number, earlier in before:
            signal.signal(number, earlier)
