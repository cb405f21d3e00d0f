"""``--watch`` of ``cb run``: edits of a program that runs, checked and taken up."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from cbdsl.diagnostics.counting import count
from cbdsl.diagnostics.errors import DiagnosticsError, UsageError
from cbdsl.reporting.live.feed import message
from cbdsl.runtime.episode_observer import EpisodeObserver

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.program.checked import CheckedProgram
    from cbdsl.program.edit import EditTaken
    from cbdsl.reporting.live.live_view import LiveView
    from cbdsl.runtime.episode_result import EpisodeResult
    from cbdsl.runtime.tick import Tick

# Wall time between looks at the files, s.
_PAUSE = 0.1

Report = Callable[..., None]
"""Receiver of a sentence about an edit and, if any, of the findings of the checker."""


class ProgramWatch(EpisodeObserver):
    """Watch of the files of a program, which offers each edit that checks to its runner.

    It reads files between ticks, while the simulated world waits. An edit that does not check is
    reported, and the program goes on as it was.

    Args:
        request: Request that runs.
        read: Function that reads the request again.
        offer: Function that receives an edited program.
        report: Receiver of reports.
        clock: Function that returns the wall time, s.
    """

    def __init__(
        self,
        request: RunRequest,
        read: Callable[[], RunRequest],
        offer: Callable[[CheckedProgram], None],
        report: Report,
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._first, self._read, self._offer, self.report = request, read, offer, report
        self._clock, self._looked = clock, clock()
        self._newest = self._running = request.program
        self._files = request.library.files
        self._stamps = self._settling = self._stamp()
        self._reported, self._plays = "", True

    def begin(self, program: CheckedProgram, stage: str, seed: int) -> None:
        """Begin an episode; see ``EpisodeObserver.begin``."""
        self._plays = True

    def note_tick(self, tick: Tick) -> None:
        """Look at the files; see ``EpisodeObserver.note_tick``."""
        self.look()

    def note_edit(self, edit: EditTaken) -> None:
        """Note an edit that is active; see ``EpisodeObserver.note_edit``."""
        if edit.depth == 0:
            self._running = edit.program
        self._reported = ""
        self.report(f"{edit.time:6.2f} s  {edit}" if self._plays else f"{edit}")

    def note_end(self, result: EpisodeResult) -> None:
        """Note the end of an episode; the next one takes up later edits."""
        self._plays = False

    @property
    def is_pending(self) -> bool:
        """True if an edit waits for a change of state."""
        return self._newest != self._running

    def has_offered(self) -> bool:
        """Look at the files, and return whether an edit has been offered."""
        newest = self._newest
        self.look()
        return self._newest is not newest

    def look(self) -> None:
        """Look at the files, and offer the program if it has changed."""
        now = self._clock()
        if now - self._looked < _PAUSE:
            return
        self._looked, stamps = now, self._stamp()
        # An editor may write a file in several parts: it counts once it stays the same.
        is_settled, self._settling = stamps == self._settling, stamps
        if is_settled and stamps != self._stamps:
            self._stamps = stamps
            self._take()

    def _take(self) -> None:
        try:
            request = self._read()
        except DiagnosticsError as error:
            lines = str(error).splitlines()
            self._renew(f"the edit has {count(len(lines), 'error')}; the program stays", lines)
            return
        except UsageError as error:
            self._renew(f"the edit cannot run: {error}; the program stays")
            return
        self._files = request.library.files
        self._stamps = self._settling = self._stamp()
        if request.robot != self._first.robot:
            robot = request.robot.name
            self._renew(f"the robot {robot} has changed: end this run and start it again")
            return
        if request.program != self._newest:
            self._newest = request.program
            self._offer(request.program)
            if self.is_pending and self._plays:
                self._renew("the edit waits for the next change of state")
        elif self._reported:
            self._renew("the edit checks, and changes nothing that runs")
        if request.stage != self._first.stage:
            self._renew(f"stage '{request.stage.name}' has changed; the world stays as it is")

    def _renew(self, text: str, findings: Sequence[str] = ()) -> None:
        whole = "\n".join((text, *findings))
        if whole != self._reported:
            self._reported = whole
            self.report(text, findings)

    def _stamp(self) -> dict[Path, tuple[int, int] | None]:
        """Return time and size of each file and its folder, in which others may appear."""
        watched = {place for file in self._files for place in (file, file.parent)}
        return {place: _stamp_of(place) for place in watched}


def watched_program(
    request: RunRequest,
    read: Callable[[], RunRequest],
    offer: Callable[[CheckedProgram], None],
    view: LiveView | None,
    *,
    prints: bool,
) -> ProgramWatch:
    """Return a watch that prints its reports, by default as errors, and shows them on a page."""

    def report(text: str, findings: Sequence[str] = ()) -> None:
        lines = (f"  {text}", *(f"    {each}" for each in findings))
        print(*lines, sep="\n", flush=True, file=None if prints else sys.stderr)
        if view is not None:
            view.keep(message("watch", {"text": text.strip(), "findings": list(findings)}))

    watch = ProgramWatch(request, read, offer, report)
    if view is not None:
        view.between_ticks(watch.look)
    return watch


def _stamp_of(place: Path) -> tuple[int, int] | None:
    try:
        status = place.stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size
