"""Log of the language server: one line for each problem on the standard error stream."""

from __future__ import annotations

import logging
import os

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
