"""Pages of commands, written atomically, and shown in the browser in interactive use."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

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


def require_page(page: Path, episodes: int) -> None:
    """Check before an episode that the page of ``cb run --page`` can be written.

    Args:
        page: File of the page.
        episodes: Number of episodes of the run.

    Raises:
        UsageError: It cannot, or there are several episodes.
    """
    if page.suffix != ".html":
        raise UsageError(f"--page {page}: a page is <name>.html")
    if episodes > 1:
        raise UsageError(
            f"--page shows one episode, not {episodes}; --record FOLDER keeps all, and cb replay "
            "FOLDER makes a page of each"
        )
    require_room(page)


@contextmanager
def recorded_for(page: Path | None, record: Path | None, *, prints: bool) -> Iterator[Path | None]:
    """Yield the folder to record in, and write the page of the recording at the end.

    Args:
        page: File of the page, or ``None`` for none.
        record: Folder for recordings, or ``None`` if they are for the page alone.
        prints: True if the page's file is printed.
    """
    if page is None:
        yield record
    elif record is not None:
        yield record
        _write_newest(record, page, prints=prints)
    else:
        with TemporaryDirectory() as temporary:
            yield Path(temporary)
            _write_newest(Path(temporary), page, prints=prints)


def _write_newest(folder: Path, target: Path, *, prints: bool) -> None:
    from cbdsl.reporting.page import page
    from cbdsl.reporting.recorded import find_recordings, read_recording

    # The folder of `--record` may hold episodes of other runs.
    newest = max(find_recordings(folder), key=lambda file: file.stat().st_mtime)
    write_page(page(read_recording(newest)), target, prints=prints)


def open_page(target: Path) -> None:
    """Show a page in the browser, if a person is there to see it."""
    if sys.stdout.isatty():
        with quiet_stderr():  # without a browser, the launcher prints many messages
            typer.launch(str(target))
