"""``cb lsp``: the language server, which an editor starts."""

from __future__ import annotations

import logging
import os
import sys
from importlib.metadata import version
from pathlib import Path

from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.legible_text import legible


class _OneLine(logging.Formatter):
    """Formatter that replaces a traceback with the name and the reason of its error."""

    def format(self, record: logging.LogRecord) -> str:
        """Return a record as one line."""
        # Some messages of pygls contain a traceback themselves.
        text = record.getMessage().partition("\n")[0]
        if record.exc_info and record.exc_info[1] is not None:
            error = record.exc_info[1]
            text = f"{text}: {type(error).__name__}: {error}"
        return f"cb lsp: {legible(text)}"


def log_lines() -> None:
    """Log problems of the protocol as lines; ``CB_TRACEBACK=1`` keeps tracebacks."""
    handler = logging.StreamHandler()
    if not os.environ.get("CB_TRACEBACK"):
        handler.setFormatter(_OneLine())
    logger = logging.getLogger("pygls")
    logger.addHandler(handler)
    logger.propagate = False


def lsp() -> None:
    """Serve an editor over the standard streams: diagnostics while typing, completion, hover.

    Editors start this server and end it; see docs/how_to/set_up_an_editor.md.
    """
    try:
        from cbdsl.editor.language_server import build
    except ModuleNotFoundError as error:
        raise UsageError(
            f"cb lsp needs {error.name}, which is not installed: pip install 'cbdsl[editor]'"
        ) from error
    # `fill_closed_streams` has replaced a closed output by the null device.
    if sys.stdin is None or sys.stdout.name == os.devnull:
        raise UsageError("cb lsp needs the standard input and output, over which an editor talks")
    log_lines()
    build(version("cbdsl"), Path.cwd()).serve(sys.stdin.buffer, sys.stdout.buffer)
