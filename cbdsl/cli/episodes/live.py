"""``--live`` of commands that run episodes: a page in the browser while they run."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from threading import Event
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.backends.quiet import quiet_stderr
from cbdsl.diagnostics.errors import UsageError

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.backends.backend import Backend
    from cbdsl.cli.episodes.program_watch import ProgramWatch
    from cbdsl.reporting.live.live_view import LiveView

Live = Annotated[bool, typer.Option("--live", help="Show the run in the browser, in real time.")]
Fast = Annotated[
    bool, typer.Option("--fast", help="With --live: run at maximum speed instead of real time.")
]
LivePort = Annotated[
    int | None,
    typer.Option(
        "--live-port", min=0, max=65535, help="With --live: port of the page [a free one]."
    ),
]
LiveWait = Annotated[
    bool, typer.Option("--live-wait", help="With --live: wait until a browser shows the page.")
]
LiveClose = Annotated[
    bool,
    typer.Option(
        "--live-close", help="With --live: end after the last episode instead of at Ctrl-C."
    ),
]

# Wall time between looks for a reason for another episode, s.
_PAUSE = 0.1
# Requests that let a run wait, and the reason why a driven robot refuses them.
_WAITING = ("pause", "step", "speed", "change", "break", "back")
_DRIVEN = (
    "a driven robot does not wait: without references its watchdog stops it; end the program with "
    "Ctrl-C, or pause it in a simulator"
)


@dataclass(frozen=True, kw_only=True)
class LiveOptions:
    """Options of the live page of a run.

    Attributes:
        live: True to show a page.
        live_port: Port of the page; ``None`` for any free port.
        live_wait: True to begin only when a browser shows the page.
        live_close: True to close the page after the last episode.
        fast: True to run at maximum speed instead of real time.
    """

    live: Live = False
    live_port: LivePort = None
    live_wait: LiveWait = False
    live_close: LiveClose = False
    fast: Fast = False

    def require_page(self) -> None:
        """Refuse options of the page without the page.

        Raises:
            UsageError: An option of the page is given without ``--live``.
        """
        given = {
            "--live-port": self.live_port is not None,
            "--fast": self.fast,
            "--live-wait": self.live_wait,
            "--live-close": self.live_close,
        }
        alone = [name for name, is_given in given.items() if is_given and not self.live]
        if alone:
            raise UsageError(f"{alone[0]} is about the page of a run: give --live, too")


@contextmanager
def live_page(
    options: LiveOptions,
    request: RunRequest,
    backend: Backend,
    *,
    composes: bool = False,
    fixed: str = "only cb run goes back",
    prints: bool = True,
) -> Iterator[LiveView | None]:
    """Serve a live page of the episodes within the context, and keep it until Ctrl-C.

    Args:
        options: Options of the page.
        request: Program, robot and stage.
        backend: Backend of the episodes.
        composes: True if the page may change the program.
        fixed: Reason why the run cannot go back to an earlier state; empty if it can.
        prints: True if messages go to the standard output.

    Raises:
        UsageError: The port of the page is not available.
    """
    if not options.live:
        yield None
        return
    from cbdsl.backends.staging.world_state import GroundTruthProvider
    from cbdsl.reporting.live.breakpoints import Breakpoints
    from cbdsl.reporting.live.composed_program import composed_program
    from cbdsl.reporting.live.feed import Feed
    from cbdsl.reporting.live.live_page import live_page as page
    from cbdsl.reporting.live.live_view import LiveView
    from cbdsl.reporting.live.page_server import LiveServer
    from cbdsl.reporting.live.requests import Requests
    from cbdsl.reporting.live.transport import Transport
    from cbdsl.runtime.program_composer import Composer

    # The backend's ground truth is only on the page, for display.
    scenery = (lambda: backend.truth) if isinstance(backend, GroundTruthProvider) else None
    is_paced = options.fast or backend.deadline is not None
    feed, transport = Feed(), Transport(math.inf if is_paced else 1.0)
    composer, breakpoints = Composer() if composes else None, Breakpoints()
    view = LiveView(feed, transport, scenery, composer, breakpoints)
    values = {key: str(value) for key, value in request.program.parameters.items()}
    refused = {"back": fixed} if fixed else {}
    if backend.deadline is not None:
        refused = dict.fromkeys(_WAITING, _DRIVEN)
    save = partial(composed_program, request.program_file, request.stage.name, values)

    def make(token: str) -> str:
        robot, urdf = request.robot, request.urdf
        return page(request.program.name, robot, urdf, token, composes=composes, refused=refused)

    requests = Requests(transport, composer, save, breakpoints, refused)
    server = LiveServer(feed, make, requests, options.live_port or 0)
    try:
        _tell(f"live at {server.url}", prints)
        _open(server.url)
        if options.live_wait:
            _tell("begins when a browser shows it", prints)
            feed.wait_for_page()
        yield view
        # An exception of the run is raised at the `yield`, so that its page closes without waiting.
        if not options.live_close:
            _stay(prints)
    finally:
        server.close()


def go_on(
    view: LiveView | None, watch: ProgramWatch | None, episode: Callable[[], None], *, prints: bool
) -> None:
    """Run another episode for each edit and each return to an earlier state, until Ctrl-C.

    Args:
        view: View of a page that stays; without one the run is over.
        watch: Watch of the program's files, if any.
        episode: Function that runs an episode.
        prints: True if messages go to the standard output.
    """
    if view is None:
        if watch is not None and watch.is_pending:
            watch.report("the last edit came too late for this run")
        return
    _tell("the page stays until Ctrl-C", prints)
    with suppress(KeyboardInterrupt):
        while True:
            time = view.take_return(_PAUSE)
            if time is not None:
                view.run_to(time)
            if time is not None or (watch is not None and watch.has_offered()):
                episode()


def _stay(prints: bool) -> None:
    """Keep the page until Ctrl-C, which ends nothing but the page."""
    try:
        _tell("the page stays until Ctrl-C", prints)
        while not Event().wait(3600):
            continue
    except KeyboardInterrupt:
        return


def _tell(text: str, prints: bool) -> None:
    print(text, file=sys.stdout if prints else sys.stderr, flush=True)


def _open(url: str) -> None:
    """Show the page, if a person sits at a screen."""
    if sys.stdout.isatty() and _has_screen():
        with quiet_stderr():  # without a browser, the launcher prints many messages
            typer.launch(url)


def _has_screen() -> bool:
    if sys.platform in ("darwin", "win32"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
