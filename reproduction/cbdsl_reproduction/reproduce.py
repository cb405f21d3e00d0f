"""``cb reproduce``: run the experiments of the source, and put our numbers beside its numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.extend.command import Cameras, Json, require_workers

if TYPE_CHECKING:
    from cbdsl_reproduction.experiment import Experiment, Result, RunSettings

_ALL = "all"

Name = Annotated[
    str | None,
    typer.Argument(metavar="NAME|all", help="Experiment, or all; see --list."),
]
ListThem = Annotated[
    bool, typer.Option("--list", help="List the experiments, or the claims of NAME.")
]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Seed of all random numbers.")]
Quick = Annotated[
    bool,
    typer.Option("--quick", help="Run small variants, which test the code and give no evidence."),
]
BackendName = Annotated[
    str | None,
    typer.Option(
        "--backend",
        help="Engine of experiments that learn, fig-5.2, fig-5.6, fig-7.13-7.14, "
        "fig-7.16-7.17 and table-7.1-7.2 [kinematic; mujoco in fig-5.6 and Chapter 7].",
    ),
]
Trials = Annotated[
    int | None,
    typer.Option(
        "--trials",
        min=1,
        help="How many times it learns from zero [30 on kinematic, else as often as the source]; "
        "with engines, how many episodes of each program run [20], with fig-5.2 how many times 25 "
        "episodes [20]; with fig-5.3-5.5, how many "
        "samples of each channel are wanted [50], with fig-5.6 of each of five ways to touch [10].",
    ),
]
Workers = Annotated[
    int | None,
    typer.Option(
        "--workers",
        min=1,
        help="Number of parallel processes; the result does not depend on it [1].",
    ),
]
Keep = Annotated[
    Path | None,
    typer.Option("--keep", help="Folder for the episodes; the same command continues from there."),
]
Out = Annotated[
    Path | None,
    typer.Option(
        "--out",
        help="Additional output: folder for a page of each chapter with pictures, or .json.",
    ),
]


def reproduce(
    name: Name = None,
    *,
    list_them: ListThem = False,
    seed: Seed = 0,
    quick: Quick = False,
    backend: BackendName = None,
    cameras: Cameras = None,
    trials: Trials = None,
    workers: Workers = None,
    keep: Keep = None,
    out: Out = None,
    as_json: Json = False,
) -> None:
    """Measure the results that the dissertation reports.

    Experiments in which the robot learns run trials, and share those of the same programs.
    --keep keeps each finished episode of these trials and of engines, fig-5.2, fig-5.3-5.5, fig-5.6
    and fig-5.12. It keeps each finished trial of fig-5.10-5.11, fig-7.13-7.14, fig-7.16-7.17 and
    table-7.1-7.2.

    Exit 0 after a run with any verdicts, 2 if it cannot run.
    """
    from cbdsl import UsageError
    from cbdsl.extend.command import print_json
    from cbdsl_reproduction.experiment import RunSettings
    from cbdsl_reproduction.report import data

    if list_them:
        _list(name, as_json)
        return
    require_workers(workers or 1)
    if name is None:
        raise UsageError("which experiment? cb reproduce --list names them, 'all' is all of them")
    chosen = _chosen(name)
    if out is not None:
        _require_writable(out)
    _require_meaning(
        name,
        chosen,
        where={"--backend": backend, "--cameras": cameras},
        often={"--trials": trials, "--keep": keep},
        workers={"--workers": workers},
    )
    results: list[dict[str, object]] = []
    with _kept(keep) as folder:
        for experiment in chosen:
            settings = RunSettings(
                seed=seed,
                quick=quick,
                backend=backend or experiment.backend or RunSettings.backend,
                cameras=cameras,
                trials=trials,
                folder=folder,
            )
            outcome = _run(experiment, settings, workers or 1)
            results.append(data(experiment, settings, outcome))
            if not as_json:
                _tell(experiment, outcome)
            if out is not None:
                # Written after each experiment, so that an interrupt of a later one loses none.
                _write(out, experiment, settings, outcome, results)
    if as_json:
        print_json(results)


def _require_meaning(
    name: str,
    chosen: Sequence[Experiment],
    *,
    where: Mapping[str, object],
    often: Mapping[str, object],
    workers: Mapping[str, object],
) -> None:
    """Refuse options that have no meaning for any of the experiments."""
    learns = f"learn, which {name} is not"
    if not any(each.backend for each in chosen):
        _require_unused(where, f"run on a backend of choice, which {name} does not")
    if not any(each.learns for each in chosen):
        _require_unused(workers, learns)
    if not any(each.learns or each.keeps for each in chosen):
        _require_unused(often, learns)


def _require_unused(options: Mapping[str, object], whose: str) -> None:
    from cbdsl import UsageError

    given = [option for option, value in options.items() if value is not None]
    if given:
        raise UsageError(f"{given[0]} is for experiments that {whose}")


@contextmanager
def _kept(folder: Path | None) -> Iterator[Path]:
    """Yield the folder of trials; without a given folder, a temporary one.

    Raises:
        UsageError: The folder cannot be created, or it holds other trials.
    """
    from tempfile import TemporaryDirectory

    from cbdsl import UsageError
    from cbdsl.api.trials import DamagedJournalError, JournalError
    from cbdsl.extend.command import print_problem, reason

    if folder is None:
        with TemporaryDirectory() as passing:
            yield Path(passing)
        return
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"--keep {folder}: {reason(error)}") from error
    _require_sound(folder)
    try:
        yield folder
    # Damage is a ``JournalError``, too, but no sign of other trials.
    except DamagedJournalError:
        raise
    except JournalError as error:
        raise UsageError(f"--keep {folder} holds other trials: {error}") from error
    except KeyboardInterrupt:
        kept = f"{folder} holds the episodes that are over; the same command goes on with them"
        print_problem(f"interrupted; {kept}")
        raise


def _require_sound(folder: Path) -> None:
    """Report damaged lines in the folder of trials.

    Raises:
        UsageError: A damaged line cannot be skipped.
    """
    from cbdsl import UsageError
    from cbdsl.extend.command import print_problem
    from cbdsl_reproduction.kept_files import damaged_lines

    for line in damaged_lines(folder):
        if not line.passed:
            raise UsageError(line.format_message())
        print_problem(f"warning: {line.format_message()}")


def _list(name: str | None, as_json: bool) -> None:
    """Print the experiments, or the claims of the named ones."""
    from cbdsl.extend.command import print_json
    from cbdsl_reproduction.registry import EXPERIMENTS
    from cbdsl_reproduction.report import claim_row

    if name is not None:
        rows = [claim_row(claim) for each in _chosen(name) for claim in each.claims()]
    else:
        rows = [
            {"experiment": each.name, "title": each.title, "section": each.section}
            for each in EXPERIMENTS.values()
        ]
    if as_json:
        print_json(rows)
    else:
        _print_rows(f"Claims of {name}" if name else "Experiments", rows)


def _chosen(name: str) -> list[Experiment]:
    from cbdsl import UsageError
    from cbdsl_reproduction.registry import EXPERIMENTS

    if name == _ALL:
        return list(EXPERIMENTS.values())
    if name not in EXPERIMENTS:
        raise UsageError.unknown("experiment", name, [*EXPERIMENTS, _ALL])
    return [EXPERIMENTS[name]]


def _run(experiment: Experiment, settings: RunSettings, workers: int) -> Result:
    from dataclasses import replace

    from cbdsl import UsageError
    from cbdsl.extend.command import (
        Progress,
        quiet_stderr,
        shown_on_failure,
        termination_interrupts,
    )
    from cbdsl_reproduction.trial_jobs import run_jobs

    try:
        with quiet_stderr():
            measure = experiment.load()
    except ModuleNotFoundError as error:
        raise UsageError(
            f"{experiment.name} needs {error.name}, which is not installed: "
            "pip install 'cbdsl[sim]'"
        ) from error
    except ImportError as error:
        # A package is installed, but it lacks a system library, such as libgomp.
        raise UsageError(f"{experiment.name} needs more than is installed: {error}") from error
    interruptible = termination_interrupts()
    with interruptible, shown_on_failure(), Progress(experiment.name) as progress:
        reported = replace(settings, progress=progress.note)
        if workers > 1 and experiment.learns:
            run_jobs(experiment, reported, workers)
        return measure(reported)


def _tell(experiment: Experiment, outcome: Result) -> None:
    from cbdsl_reproduction.report import row

    rows = [row(quantity) for quantity in outcome.quantities]
    _print_rows(f"{experiment.name}: {experiment.title} ({experiment.section})", rows)
    for note in outcome.notes:
        print(note)
    print(flush=True)


def _print_rows(title: str, rows: list[dict[str, str]]) -> None:
    """Print rows as a table on a terminal, and as one line per row to a pipe."""
    import sys

    from cbdsl.extend.command import print_table

    if sys.stdout.isatty():
        print_table(title, rows)
        return
    print(title)
    for cells in rows:
        print("\t".join(cells.values()))


def _require_writable(out: Path) -> None:
    """Check before the experiments that their outcomes can be written."""
    from cbdsl import UsageError
    from cbdsl.api.documents import make_room
    from cbdsl.extend.command import reason

    if out.suffix not in ("", ".json"):
        raise UsageError(f"--out {out}: expected a folder, or a file that ends in .json")
    try:
        make_room(out if out.suffix else out / "index.md")
    except OSError as error:
        raise UsageError(f"--out {out}: cannot be written ({reason(error)})") from error


def _write(
    out: Path,
    experiment: Experiment,
    settings: RunSettings,
    outcome: Result,
    results: list[dict[str, object]],
) -> None:
    import json

    from cbdsl.api.documents import write_text
    from cbdsl_reproduction.pages import (
        SUMMARY,
        chapter_page,
        existing_pages,
        page_of,
        summary_page,
    )
    from cbdsl_reproduction.registry import EXPERIMENTS
    from cbdsl_reproduction.report import heading, picture_file, section

    if out.suffix == ".json":
        write_text(json.dumps(results, indent=1, ensure_ascii=False) + "\n", out)
        return
    for chart in outcome.charts:
        write_text(chart.svg(), out / picture_file(chart, experiment, settings))
    order, name = EXPERIMENTS.values(), page_of(experiment)
    new = {heading(experiment, settings): section(experiment, settings, outcome)}
    before = existing_pages(out, order).get(name, "")
    write_text(chapter_page(name, before, new, order), out / f"{name}.md")
    write_text(summary_page(existing_pages(out, order)), out / SUMMARY)
