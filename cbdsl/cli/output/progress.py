"""Progress of a command that takes a while, on the standard error."""

from __future__ import annotations

import sys
import time

from cbdsl.cli.process.legible_output import raw
from cbdsl.diagnostics.legible_text import legible

#: Minimum duration of a command that reports progress, s.
_PATIENCE = 2.0
# A terminal's line is replaced; elsewhere every line stays.
_PAUSE_ON_TERMINAL, _PAUSE_ELSEWHERE = 0.2, 20.0
# Characters of a terminal's bar.
_WIDTH = 24


class Progress:
    """Printer of the number of finished parts and the remaining time, with a bar on a terminal.

    Args:
        heading: Words at the beginning of the line.
    """

    def __init__(self, heading: str) -> None:
        self._heading = heading
        self._terminal = sys.stderr.isatty()
        self._pause = _PAUSE_ON_TERMINAL if self._terminal else _PAUSE_ELSEWHERE
        self._began = time.monotonic()
        # The first report is due after `_PATIENCE`, and the following ones after `_pause` each.
        self._last = self._began + _PATIENCE - self._pause
        self._shown = False

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        self.clear()

    def clear(self) -> None:
        """Clear the line of a terminal; ``note`` shows it again."""
        if self._shown and self._terminal:
            print("\r\x1b[K", end="", file=raw(sys.stderr), flush=True)
            self._shown = False

    def note(self, done: int, total: int) -> None:
        """Report ``done`` of ``total`` parts of about the same length."""
        now = time.monotonic()
        if now < self._last + self._pause:
            return
        self._last, self._shown = now, True
        text = f"{self._heading}: {self._bar(done, total)}{done} of {total}"
        if done:
            left = (now - self._began) / done * (total - done)
            text += f", about {left // 60:.0f} min {left % 60:02.0f} s left"
        if self._terminal:
            # The escape that clears the line is intended, and has to pass the legible stream
            # unchanged.
            print(f"\r\x1b[K{legible(text)}", end="", file=raw(sys.stderr), flush=True)
        else:
            print(text, file=sys.stderr, flush=True)

    def _bar(self, done: int, total: int) -> str:
        if not self._terminal:
            return ""
        full = _WIDTH * done // max(total, 1)
        return f"[{'#' * full}{'.' * (_WIDTH - full)}] "
