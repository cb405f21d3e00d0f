"""``cb reproduce``: run the experiments of the source, and put our numbers beside its numbers."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from cbdsl.reproduction.experiment import Experiment, Outcome, Settings

_ALL = "all"

Name = Annotated[
    str | None,
    typer.Argument(metavar="NAME|all", help="An experiment, or all of them; see --list."),
]
ListThem = Annotated[bool, typer.Option("--list", help="List the experiments.")]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Seed of everything random.")]
Quick = Annotated[
    bool,
    typer.Option("--quick", help="Small variants, which show that it works and prove nothing."),
]
Out = Annotated[
    Path | None,
    typer.Option(
        "--out", help="File to write as well: .md for a page with pictures beside it, or .json."
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of tables.")]


def reproduce(
    name: Name = None,
    list_them: ListThem = False,
    seed: Seed = 0,
    quick: Quick = False,
    out: Out = None,
    as_json: Json = False,
) -> None:
    """Measure what the dissertation reports.

    Exit 0 when it ran, whatever the verdicts, and 2 when it could not run.
    """
    from cbdsl.cli.terminal import print_json
    from cbdsl.errors.errors import UsageError
    from cbdsl.reproduction.experiment import Settings
    from cbdsl.reproduction.report import data

    if list_them:
        _list(as_json)
        return
    if name is None:
        raise UsageError("which experiment? cb reproduce --list names them, 'all' is all of them")
    chosen = _chosen(name)
    if out is not None:
        _require_writable(out)
    settings = Settings(seed=seed, quick=quick)
    found: list[dict[str, object]] = []
    for experiment in chosen:
        outcome = _run(experiment, settings)
        found.append(data(experiment, settings, outcome))
        if not as_json:
            _tell(experiment, outcome)
        if out is not None:
            # After each, so that what is done is kept when a later one is interrupted.
            _write(out, experiment, settings, outcome, found)
    if as_json:
        print_json(found)


def _list(as_json: bool) -> None:
    from cbdsl.cli.terminal import print_json
    from cbdsl.reproduction.registry import EXPERIMENTS

    rows = [
        {"experiment": each.name, "title": each.title, "section": each.section}
        for each in EXPERIMENTS.values()
    ]
    if as_json:
        print_json(rows)
    else:
        _print_rows("Experiments", rows)


def _chosen(name: str) -> list[Experiment]:
    from cbdsl.errors.errors import UsageError
    from cbdsl.errors.nearest import nearest_name
    from cbdsl.reproduction.registry import EXPERIMENTS

    if name == _ALL:
        return list(EXPERIMENTS.values())
    if name not in EXPERIMENTS:
        nearest = nearest_name(name, [*EXPERIMENTS, _ALL])
        hint = f"; did you mean '{nearest}'?" if nearest else ""
        known = ", ".join([*EXPERIMENTS, _ALL])
        raise UsageError(f"there is no experiment '{name}'{hint} (known: {known})")
    return [EXPERIMENTS[name]]


def _run(experiment: Experiment, settings: Settings) -> Outcome:
    from dataclasses import replace

    from cbdsl.cli.progress import Progress
    from cbdsl.cli.quiet import quiet_stderr, shown_on_failure
    from cbdsl.errors.errors import UsageError

    try:
        with quiet_stderr():
            measure = experiment.load()
    except ModuleNotFoundError as error:
        raise UsageError(
            f"{experiment.name} needs {error.name}, which is not installed: "
            "pip install 'cbdsl[sim]'"
        ) from error
    except ImportError as error:
        # A package is there, but not a system library that it needs, such as libgomp.
        raise UsageError(f"{experiment.name} needs more than is installed: {error}") from error
    with shown_on_failure(), Progress(experiment.name) as progress:
        return measure(replace(settings, progress=progress.note))


def _tell(experiment: Experiment, outcome: Outcome) -> None:
    from cbdsl.reproduction.report import row

    rows = [row(quantity) for quantity in outcome.quantities]
    _print_rows(f"{experiment.name}: {experiment.title} ({experiment.section})", rows)
    for note in outcome.notes:
        print(note)
    print(flush=True)


def _print_rows(title: str, rows: list[dict[str, str]]) -> None:
    """A table for people, a line per row for pipes."""
    import sys

    from cbdsl.cli.terminal import print_table

    if sys.stdout.isatty():
        print_table(title, rows)
        return
    print(title)
    for cells in rows:
        print("\t".join(cells.values()))


def _require_writable(out: Path) -> None:
    """Find out before the experiments, not after, whether their outcomes can be kept."""
    from cbdsl.errors.errors import UsageError
    from cbdsl.yaml_text.writer import make_room

    if out.suffix not in (".md", ".json"):
        raise UsageError(f"--out {out}: expected a file that ends in .md or .json")
    try:
        make_room(out)
    except OSError as error:
        raise UsageError(f"--out {out}: cannot be written ({error.strerror or error})") from error


def _write(
    out: Path,
    experiment: Experiment,
    settings: Settings,
    outcome: Outcome,
    found: list[dict[str, object]],
) -> None:
    import json

    from cbdsl.reproduction.registry import EXPERIMENTS
    from cbdsl.reproduction.report import page, section
    from cbdsl.yaml_text.writer import write_text

    if out.suffix == ".json":
        write_text(json.dumps(found, indent=1, ensure_ascii=False) + "\n", out)
        return
    pictures = out.with_suffix("")
    if outcome.charts:
        pictures.mkdir(exist_ok=True)
    for chart in outcome.charts:
        write_text(chart.svg(), pictures / f"{chart.name}.svg")
    before = out.read_text(encoding="utf-8") if out.exists() else ""
    new = {experiment.name: section(experiment, settings, outcome, pictures.name)}
    write_text(page(before, new, EXPERIMENTS), out)
