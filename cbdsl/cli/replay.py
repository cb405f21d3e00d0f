"""``cb replay``: a recorded episode as a page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cbdsl.cli.arguments.options import Open, Recording
from cbdsl.cli.episodes.pages import open_page, require_room, write_page
from cbdsl.cli.output.terminal import print_line
from cbdsl.diagnostics.errors import UsageError

Out = Annotated[
    Path | None, typer.Option("--out", help="File of the page [beside the recording, .html].")
]


def replay(what: Recording, out: Out = None, open_: Open = True) -> None:
    """Write a self-contained page of a recorded episode.

    Exit 0 if the page was written, 2 if it cannot be made.
    """
    try:
        from cbdsl.reporting.recorded import find_recordings
    except ModuleNotFoundError as error:
        raise UsageError(
            f"a replay needs {error.name}, which is not installed: pip install 'cbdsl[sim]'"
        ) from error
    recordings = find_recordings(what)
    if out is not None and len(recordings) > 1:
        raise UsageError(
            f"--out {out}: {what} holds {len(recordings)} recordings; name one of them"
        )
    targets = {file: out or file.with_suffix(".html") for file in recordings}
    # All targets are checked before the first page is made.
    follow = out is not None
    for target in targets.values():
        require_room(target, follow=follow)
    pages = [_write(file, target, follow) for file, target in targets.items()]
    if open_ and len(pages) == 1:
        open_page(pages[0])


def _write(recording: Path, target: Path, follow: bool) -> Path:
    from cbdsl.reporting.page import page
    from cbdsl.reporting.recorded import read_recording

    recorded = read_recording(recording)
    write_page(page(recorded), target, follow=follow)
    if change := recorded.program_change():
        print_line(change)
    return target
