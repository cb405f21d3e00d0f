"""Pages of commands, written atomically, and shown in the browser in interactive use."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import typer

from cbdsl.backends.quiet import quiet_stderr
from cbdsl.cli.output.terminal import print_line
from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.legible_text import encoded
from cbdsl.diagnostics.reason import reason
from cbdsl.storage.atomic_file import make_room, write_text


def require_room(target: Path, *, follow: bool = True) -> None:
    """Create the folder of a page, and check before the run that the page can be written.

    Args:
        target: File of the page.
        follow: True if the user gave its name, so that a link is followed.

    Raises:
        UsageError: The page cannot be written.
    """
    with _writing(target):
        make_room(target, follow=follow)


def write_page(text: str, target: Path, *, prints: bool = True, follow: bool = True) -> None:
    """Write a page, and print its path and size.

    Raises:
        UsageError: The page cannot be written; an existing file is unchanged.
    """
    with _writing(target):
        write_text(text, target, follow=follow)
    if prints:
        print_line(f"{target}: {len(encoded(text)) / 1e6:.1f} MB")


@contextmanager
def _writing(target: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise UsageError(f"{target}: cannot be written ({reason(error)})") from error


def open_page(target: Path) -> None:
    """Show a page in the browser, if a person is there to see it."""
    if sys.stdout.isatty():
        with quiet_stderr():  # without a browser, the launcher prints many messages
            typer.launch(str(target))
