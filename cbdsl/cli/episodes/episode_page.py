"""The page of ``cb run --page``: the replay of one episode, as one file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from cbdsl.cli.episodes.pages import require_room, write_page
from cbdsl.diagnostics.errors import UsageError


def require_page(page: Path, episodes: int) -> None:
    """Check before the episode that its page can be written.

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
        _write(record, page, prints=prints)
    else:
        with TemporaryDirectory() as temporary:
            yield Path(temporary)
            _write(Path(temporary), page, prints=prints)


def _write(folder: Path, target: Path, *, prints: bool) -> None:
    from cbdsl.reporting.page import page
    from cbdsl.reporting.recorded import find_recordings, read_recording

    # The folder of `--record` may hold episodes of other runs.
    newest = max(find_recordings(folder), key=lambda file: file.stat().st_mtime)
    write_page(page(read_recording(newest)), target, prints=prints)
