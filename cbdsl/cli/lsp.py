"""``cb lsp``: the language server, which an editor starts."""

from __future__ import annotations

import os
import sys
from importlib.metadata import version
from pathlib import Path

from cbdsl.cli.output.server_log import log_lines
from cbdsl.diagnostics.errors import UsageError


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
