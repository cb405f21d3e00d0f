"""How far something is that takes a while, on the standard error."""

from __future__ import annotations

import sys
import time

#: What is over sooner needs no telling, s.
_PATIENCE = 2.0
# A terminal's line is replaced; elsewhere every line stays.
_PAUSE_ON_TERMINAL, _PAUSE_ELSEWHERE = 0.2, 20.0


class Progress:
    """Tells how many of how many parts are done and how long the rest will take.

    Args:
        what: a few words at the beginning of the line.
    """

    def __init__(self, what: str) -> None:
        self._what = what
        self._terminal = sys.stderr.isatty()
        self._pause = _PAUSE_ON_TERMINAL if self._terminal else _PAUSE_ELSEWHERE
        self._began = time.monotonic()
        self._last = self._began + _PATIENCE - self._pause
        self._shown = False

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self._shown and self._terminal:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)

    def note(self, done: int, total: int) -> None:
        """``done`` of ``total`` parts of about the same length are over."""
        now = time.monotonic()
        if now < self._last + self._pause:
            return
        self._last, self._shown = now, True
        text = f"{self._what}: {done} of {total}"
        if done:
            left = (now - self._began) / done * (total - done)
            text += f", about {left // 60:.0f} min {left % 60:02.0f} s left"
        if self._terminal:
            print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)
        else:
            print(text, file=sys.stderr, flush=True)
