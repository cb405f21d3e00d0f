"""Pages that commands make: written in one step, and shown to whoever sits at a terminal."""

from __future__ import annotations

import sys
from pathlib import Path

import typer


def write_page(text: str, target: Path) -> None:
    """Write a page, and print where it is.

    Raises:
        UsageError: it cannot be written; what was there is still there.
    """
    from cbdsl.errors.errors import UsageError
    from cbdsl.yaml_text.writer import write_text

    try:
        write_text(text, target)
    except OSError as error:
        raise UsageError(f"{target}: cannot be written ({error.strerror or error})") from error
    print(f"{target}: {len(text.encode()) / 1e6:.1f} MB")


def open_page(target: Path) -> None:
    """Show a page in the browser, if a person is there to see it."""
    from cbdsl.cli.quiet import quiet_stderr

    if sys.stdout.isatty():
        with quiet_stderr():  # a machine without a browser has much to say about it
            typer.launch(str(target))
