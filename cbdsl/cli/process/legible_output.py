"""Standard output and error streams that escape unprintable characters.

All output of a command passes through these streams. Characters that move a terminal's cursor,
change its state or show nothing are written as escapes, which are valid in JSON, too.
"""

from __future__ import annotations

import errno
import io
import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO, cast

from cbdsl.diagnostics.legible_text import seen

# Colours of diagnostics, only for terminals, equal to the colours of cbdsl.diagnostics.text_format.
_COLORS = ("\033[0m", "\033[1m", "\033[1;31m", "\033[1;33m", "\033[36m")

# Attributes that every text stream has, forwarded to the underlying stream.
_OF_STREAM = (
    "buffer", "closed", "encoding", "errors", "line_buffering", "newlines", "reconfigure",
)  # fmt: skip


class LegibleStream(io.TextIOBase):
    """Text stream that escapes unseen characters, except line breaks and tabs.

    Args:
        stream: Underlying stream.

    Attributes:
        raw_stream: The same stream, for texts that are legible and escapes that are intended.
    """

    def __init__(self, stream: TextIO) -> None:
        self.raw_stream = stream
        self._is_terminal = stream.isatty()

    def write(self, text: str) -> int:
        """Write a text."""
        try:
            self.raw_stream.write(_legible_lines(text, colors=self._is_terminal))
        except OSError as error:
            self._leave(error)
        return len(text)

    def flush(self) -> None:
        """Flush the stream."""
        try:
            self.raw_stream.flush()
        except OSError as error:
            self._leave(error)

    def _leave(self, error: OSError) -> None:
        """Discard output to a closed terminal, so that a command ends in order.

        Raises:
            OSError: The error has another reason.
        """
        if error.errno != errno.EIO or not self._is_terminal:
            raise error
        os.dup2(os.open(os.devnull, os.O_WRONLY), self.fileno())

    def isatty(self) -> bool:
        """Return whether the stream is a terminal."""
        return self._is_terminal

    def fileno(self) -> int:
        """Return the stream's descriptor."""
        return self.raw_stream.fileno()

    def writable(self) -> bool:
        """Return True."""
        return True

    def __getattr__(self, name: str) -> Any:
        """Return an attribute that only the stream behind has, such as its name."""
        # Without this case, a lookup before `__init__`, as by `copy`, would call itself forever.
        if name == "raw_stream":
            raise AttributeError(name)
        return getattr(self.raw_stream, name)

    def __getattribute__(self, name: str) -> Any:
        # `TextIOBase` has these attributes itself, so that `__getattr__` is not called for them.
        if name in _OF_STREAM:
            return getattr(self.raw_stream, name)
        return super().__getattribute__(name)


def raw(stream: TextIO | None) -> TextIO | None:
    """Return the stream behind a legible one, for output whose texts are legible already."""
    return getattr(stream, "raw_stream", stream)


@contextmanager
def legible_output() -> Iterator[None]:
    """Make everything legible that is printed meanwhile."""
    streams = sys.stdout, sys.stderr
    for stream in streams:
        if isinstance(stream, io.TextIOWrapper):
            # Characters that a terminal's encoding lacks are escaped, too.
            stream.reconfigure(errors="backslashreplace")
    sys.stdout, sys.stderr = (
        stream if stream is None else cast(TextIO, LegibleStream(stream)) for stream in streams
    )
    try:
        yield
    finally:
        for stream in (sys.stdout, sys.stderr):
            _flush(stream)
        sys.stdout, sys.stderr = streams


def _flush(stream: TextIO | None) -> None:
    if stream is None or stream.closed:
        return
    try:
        stream.flush()
    except BrokenPipeError:
        # The reader has closed the pipe; nothing may be flushed at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _legible_lines(text: str, *, colors: bool = False) -> str:
    # Nearly all texts end here; the pattern below is slower.
    if text.replace("\n", "").replace("\t", "").isprintable():
        return text
    kept = _COLORS if colors else ()
    pattern = "|".join(map(re.escape, (*kept, "\n", "\t")))
    pieces = re.split(f"({pattern})", text)
    # Every other piece is a kept sequence.
    pieces[::2] = [seen(piece, _escape) for piece in pieces[::2]]
    return "".join(pieces)


def _escape(character: str) -> str:
    return f"\\u{ord(character):04x}"
