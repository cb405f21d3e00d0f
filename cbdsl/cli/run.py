"""``cb run``: run of a program with its output."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, nullcontext
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.checking.rules.stage_colors import absent_channels
from cbdsl.cli.arguments.option_groups import grouped
from cbdsl.cli.arguments.options import Program
from cbdsl.cli.arguments.run_options import RunOptions
from cbdsl.cli.episodes.attendance import Interface, Yes, attend
from cbdsl.cli.episodes.episode_tally import EpisodeTally
from cbdsl.cli.episodes.live import LiveOptions, go_on, live_page
from cbdsl.cli.episodes.pages import recorded_for, require_page
from cbdsl.cli.episodes.parallel_episodes import run_parallel
from cbdsl.cli.episodes.recorder import Recorder
from cbdsl.cli.episodes.simulation import simulation
from cbdsl.cli.process.native_output import shown_on_failure
from cbdsl.cli.process.termination import termination_interrupts
from cbdsl.diagnostics.errors import UsageError

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.backends.backend import Backend
    from cbdsl.cli.episodes.program_watch import ProgramWatch
    from cbdsl.documents.stage import StageDocument
    from cbdsl.kinematics.kinematics import Kinematics
    from cbdsl.reporting.live.live_view import LiveView
    from cbdsl.runtime.episode import Runner
    from cbdsl.runtime.episode_observer import EpisodeObserver
    from cbdsl.runtime.episode_result import EpisodeResult
    from cbdsl.runtime.recording import Recording


Record = Annotated[
    Path | None,
    typer.Option("--record", help="Folder for recordings of every tick, as NPZ and JSON."),
]
Overwrite = Annotated[
    bool, typer.Option("--overwrite", help="Let --record replace recordings of the same seeds.")
]
Page = Annotated[
    Path | None,
    typer.Option("--page", help="File for a self-contained page of the episode (.html)."),
]
Explain = Annotated[
    bool,
    typer.Option(
        "--explain", help="Explain the motion of each level of the stack as well; not with --json."
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object per episode.")]


#: Exit codes of a program that states success or failure.
_FAILED, _UNDECIDED = 3, 4


@dataclass(frozen=True)
class Telling:
    """Outputs of an episode.

    Attributes:
        recorder: Recorder of the episodes, or ``None``.
        explain: True to print the stack's levels.
        as_json: True for output as JSON.
        live: View that feeds the page in the browser, or ``None``.
        watch: Watch of the program's files, or ``None``.
    """

    recorder: Recorder | None
    explain: bool
    as_json: bool
    live: LiveView | None = None
    watch: ProgramWatch | None = None

    def print(self, result: EpisodeResult) -> None:
        """Print the outcome of an episode."""
        from cbdsl.cli.output.narration import json_line

        print(json_line(result) if self.as_json else f"  {result.ending}", flush=True)


@dataclass(frozen=True, kw_only=True)
class OutputOptions:
    """Outputs of a run: recordings, page and printed lines."""

    record: Record = None
    overwrite: Overwrite = False
    page: Page = None
    explain: Explain = False
    as_json: Json = False

    @property
    def of_one(self) -> dict[str, object]:
        """Values of the options that show the episodes of one process."""
        return {"--explain": self.explain, "--page": self.page, "--record": self.record}

    def fixed(self, stage: StageDocument) -> str:
        """Return the reason why a run cannot go back to an earlier state; empty if it can."""
        if self.record is not None or self.page is not None:
            return "a recording holds one episode: leave out --record and --page"
        goes_on = stage.world.persistent
        return f"the world of stage '{stage.name}' goes on between episodes" if goes_on else ""

    def require_exclusive(self, *, watches: bool) -> None:
        """Refuse outputs that exclude each other, or miss another.

        Args:
            watches: True if edits change the program.

        Raises:
            UsageError: Some outputs do.
        """
        if watches and (self.record is not None or self.page is not None):
            raise UsageError("a recording holds one program: leave out --watch, or record later")
        if self.overwrite and self.record is None:
            raise UsageError("--overwrite is about recordings: give their folder with --record")
        if self.explain and self.as_json:
            raise UsageError("--explain prints text and --json prints JSON: choose one")


@grouped
def run(
    program: Program,
    *,
    options: RunOptions,
    output: OutputOptions,
    live: LiveOptions,
    yes: Yes = False,
    interface: Interface = None,
) -> None:
    """Run a program on a robot and print each change of its state.

    Programs and stages are files or names; an unknown name lists the known ones.

    Exit 0 after a run, with or without a reward. A program that states success or failure exits
    with 0 if all episodes succeeded, 3 if one failed, and 4 if none failed and one ended with
    neither. Exit 1 if a document has errors, 2 if the program cannot run, and 130 after Ctrl-C or
    SIGTERM, with the finished recordings.
    """
    output.require_exclusive(watches=options.watch)
    options.require_exclusive()
    live.require_page()
    request = options.request(program)
    if options.workers > 1:
        given = {**output.of_one, "--live": live.live, "--yes": yes, "--interface": interface}
        _run_parallel(request, options, given, as_json=output.as_json)
        return
    if output.page is not None:
        require_page(output.page, options.episodes)
    # Contexts end in reverse order: the page and the backend close while SIGTERM still interrupts,
    # and the output of C is still captured.
    opened = simulation(request, options.backend, gui=options.gui, cameras=options.cameras)
    prints = not output.as_json
    with ExitStack() as within:
        within.enter_context(shown_on_failure())
        within.enter_context(termination_interrupts())
        embodied, kinematics = within.enter_context(opened)
        attend(embodied, kinematics, request, yes=yes, interface=interface)
        if options.watch and embodied.deadline is not None:
            raise UsageError("--watch is for simulators: reading an edit would delay a robot")
        runner = _runner(request, kinematics, embodied)
        seeds = range(options.seed, options.seed + options.episodes)
        recording = recorded_for(output.page, output.record, prints=prints)
        folder, recorder = within.enter_context(recording), None
        if folder is not None:
            names = prints and output.record is not None
            recorder = Recorder(
                folder, request, embodied, seeds, overwrite=output.overwrite, prints=names
            )
        composes, fixed = options.schema is None, output.fixed(request.stage)
        shown = replace(live, live_close=True)
        page = live_page(shown, request, embodied, composes=composes, fixed=fixed, prints=prints)
        view = within.enter_context(page)
        read = partial(options.request, program)
        watch = _watch(request, read, runner, view, prints=prints) if options.watch else None
        telling = Telling(recorder, output.explain, output.as_json, view, watch)
        if prints:
            print("\n".join([_introduction(request, options.backend, embodied), *_notes(request)]))
        tally = _run_all(runner, request, seeds, options.context, telling)
        more = partial(_episode, runner, request, seeds[-1], options.context, telling)
        shown_on = None if live.live_close else view
        go_on(shown_on, watch, lambda: tally.add(more(), again=True), prints=prints)
    _conclude(request, tally)


def _watch(
    request: RunRequest,
    read: Callable[[], RunRequest],
    runner: Runner,
    view: LiveView | None,
    *,
    prints: bool,
) -> ProgramWatch:
    from cbdsl.cli.episodes.program_watch import watched_program  # imports numpy

    return watched_program(request, read, runner.offer, view, prints=prints)


def _run_all(
    runner: Runner, request: RunRequest, seeds: Sequence[int], context: str | None, telling: Telling
) -> EpisodeTally:
    """Run an episode for each seed, and print a summary at the end."""
    tally = EpisodeTally()
    for index, seed in enumerate(seeds):
        if not telling.as_json:
            print(tally.heading(seed, index, len(seeds)))
        tally.add(_episode(runner, request, seed, context, telling))
    if len(seeds) > 1 and not telling.as_json:
        print(tally.summary(states_success=bool(request.program.success)))
    return tally


def _run_parallel(
    request: RunRequest, options: RunOptions, shown: Mapping[str, object], *, as_json: bool
) -> None:
    """Run episodes in processes, and print their endings and a summary."""
    of_one = {**shown, "--gui": options.gui, "--watch": options.watch}
    if option := next((option for option, given in of_one.items() if given), None):
        raise UsageError(f"{option} is for episodes of one process: leave out --workers")
    tell = Telling(None, explain=False, as_json=as_json).print
    tally = run_parallel(request, options, tell)
    if not as_json:
        print(tally.summary(states_success=bool(request.program.success)))
    _conclude(request, tally)


def _conclude(request: RunRequest, tally: EpisodeTally) -> None:
    """Exit with the code of the outcomes, if the program states success or failure."""
    if not (request.program.success or request.program.failure):
        return
    if tally.outcomes["failure"]:
        raise typer.Exit(_FAILED)
    if tally.outcomes[""]:
        raise typer.Exit(_UNDECIDED)


def _introduction(request: RunRequest, name: str, backend: Backend) -> str:
    """Return program, stage and name of the engine, and the renderer if there are images."""
    images = f"; images by {backend.renderer}" if request.robot.cameras else ""
    return f"{request.program.name} on {request.stage.name}; engine {name}{images}"


def _notes(request: RunRequest) -> list[str]:
    """Return sentences on colours that a program acts on and no object of its stage has.

    Assumptions about the robot are notes of ``cb validate`` on its document.
    """
    if not request.robot.cameras:
        return []
    channels = absent_channels(request.program, request.stage, request.robot.vision.channels)
    return [
        f"note: nothing on stage '{request.stage.name}' is of {channel}" for channel in channels
    ]


def _runner(request: RunRequest, kinematics: Kinematics, backend: Backend) -> Runner:
    from cbdsl.runtime.episode import Runner

    return Runner(request.robot, kinematics, request.program, backend)


def _episode(
    runner: Runner, request: RunRequest, seed: int, context: str | None, telling: Telling
) -> EpisodeResult:
    """Run an episode, again after each request to return to an earlier state of it."""
    from cbdsl.runtime.episode_observer import ReturnRequest

    while True:
        try:
            return _attempt(runner, request, seed, context, telling)
        except ReturnRequest as back:
            if not telling.as_json:
                print(f"  {back}: seed {seed} runs again", flush=True)
            assert telling.live is not None
            telling.live.run_to(back.time)


def _attempt(
    runner: Runner, request: RunRequest, seed: int, context: str | None, telling: Telling
) -> EpisodeResult:
    """Run an episode and print its outcome; keep its recording even after an error."""
    from cbdsl.backends.backend import BackendError
    from cbdsl.runtime.episode import DeadlineError
    from cbdsl.runtime.episode_observer import EpisodeListeners, EpisodeObservers

    ended: list[EpisodeResult] = []
    recorder = telling.recorder
    with nullcontext() if recorder is None else recorder.episode(seed, ended) as recording:
        # The observers receive the result even if an exception ends the episode, unlike the caller
        # of `run`.
        observer = EpisodeObservers(
            EpisodeListeners(on_end=ended.append), *_observers(telling, recording)
        )
        try:
            runner.run(request.stage, seed, context, observer)
        except BackendError as error:
            raise UsageError(f"seed {seed}: {error}") from error
        except DeadlineError:
            # Scripts get one object for each episode, also for one that missed its deadline.
            if telling.as_json:
                telling.print(ended[0])
            raise
        except KeyboardInterrupt:
            if ended and not telling.as_json:
                telling.print(ended[0])
            raise
        telling.print(ended[0])
    return ended[0]


def _observers(telling: Telling, recording: Recording | None) -> Iterator[EpisodeObserver]:
    """Yield the observers of an episode, in the order of their output."""
    from cbdsl.cli.output.narration import Narration, StackNarration

    if not telling.as_json:
        yield Narration()
    if telling.explain:
        yield StackNarration()
    if recording is not None:
        yield recording
    if telling.watch is not None:
        yield telling.watch
    if telling.live is not None:
        yield telling.live
