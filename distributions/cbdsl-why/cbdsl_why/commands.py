"""``cb why``: the first cause of an episode that did not succeed."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import typer

from cbdsl import UsageError
from cbdsl.extend.command import (
    Open,
    RunOptions,
    grouped,
    needing_simulation,
    open_page,
    print_problem,
    require_room,
    write_page,
)
from cbdsl_why.recorded_episodes import diagnosed, diagnosis_row, recorded_episodes

# Largest number of contradictions, and of other causes, in the text.
_MOST = 3

What = Annotated[
    str,
    typer.Argument(
        metavar="RECORDING|PROGRAM",
        help="Recording of cb run --record, a folder of recordings, or a program to run.",
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object per episode.")]
Page = Annotated[
    Path | None,
    typer.Option("--page", help="File for a page of the first failed episode (.html)."),
]
Try = Annotated[
    bool,
    typer.Option(
        "--try",
        help="Program: try single changes of it on the failed seed, and then on five others.",
    ),
]
Apply = Annotated[
    bool, typer.Option("--apply", help="As --try, and write the best change to its document.")
]


@grouped
def why(
    what: What,
    *,
    options: RunOptions,
    as_json: Json = False,
    page: Page = None,
    open_: Open = True,
    try_: Try = False,
    apply: Apply = False,
) -> None:
    """Print the first cause of an episode that did not succeed.

    The cause rests on the predicates, levels and signals of the recording; the truth of a
    simulation is not read. A cause is stated only if the recorded facts agree until then. If none
    is known, the facts that contradict each other are printed, or the causes that are ruled out.
    A program runs first, with the options of cb run; a recording needs none of them.
    With --try, single changes run on the same seed, with the same noise: of speeds, forces, gains,
    windows, guards, limits, exits and effectors, and last of masses and friction of the stage. A
    change is printed if it raises the rate of success on five fresh seeds. Goals and tolerances
    stay, and no exit skips a step.

    Exit 0 if each episode succeeded or has a known cause, and 3 if a cause is unknown. Exit 1 if a
    document has errors, and 2 if there is nothing to explain, or a recording cannot be read; the
    others of its folder are explained.
    """
    if page is not None:
        require_room(page)
    if options.workers > 1 or options.watch:
        raise UsageError("--workers and --watch are for cb run: cb why runs episodes one by one")
    if (try_ or apply) and _is_recording(what):
        raise UsageError("a recording cannot run again: give the program and its seed to --try")
    unknown = unread = False
    with _recordings(what, options) as files:
        for file in files:
            try:
                history, diagnosis = diagnosed(file)
            except UsageError as error:
                print_problem(str(error))
                unread = True
                continue
            row = diagnosis_row(history, diagnosis)
            row["changed"] = history.recorded.program_change()
            if (try_ or apply) and diagnosis.failed:
                from cbdsl_why.patches import patched

                row |= patched(what, options, history, diagnosis, apply=apply)
            print(json.dumps(row, ensure_ascii=False) if as_json else _text(row), flush=True)
            unknown |= diagnosis.failed and diagnosis.cause is None
            if page is not None and diagnosis.failed:
                from cbdsl.extend.command import page as page_of

                write_page(page_of(history.recorded), page, prints=not as_json)
                if open_:
                    open_page(page)
                page = None
    if unread or unknown:
        raise typer.Exit(2 if unread else 3)


@contextmanager
def _recordings(what: str, options: RunOptions) -> Iterator[Iterator[Path]]:
    """Yield the recordings to explain; those of a program are made one by one, and temporary."""
    path = Path(what)
    if _is_recording(what):
        with needing_simulation():
            from cbdsl.extend.diagnosis import find_recordings
        yield iter(find_recordings(path))
        return
    with TemporaryDirectory() as folder:
        options.require_exclusive()
        seeds = range(options.seed, options.seed + options.episodes)
        yield recorded_episodes(
            options.request(what),
            options.backend,
            options.cameras,
            seeds,
            Path(folder),
            context=options.context,
            gui=options.gui,
        )


def _is_recording(what: str) -> bool:
    path = Path(what)
    return path.is_dir() or path.suffix in (".json", ".npz")


def _clause(cause: dict[str, Any]) -> str:
    return f"{cause['time']:.2f} s: {cause['sentence']}"


def _text(row: dict[str, Any]) -> str:
    """Return the diagnosis of an episode as text."""
    heading = f"{row['program']} on {row['stage']}, seed {row['seed']}"
    if not row["failed"]:
        return f"{heading}: it did not fail. {row['ending']}"
    cause, lines = row["cause"], [each for each in (row["missing"], row["changed"]) if each]
    if cause is None:
        lines.append("I do not know." if row["doubts"] else "I do not know. Ruled out:")
        lines += [f"  {each}" for each in row["doubts"][:_MOST] or row["ruled_out"]]
        lines += [f"  then at {_clause(each)}" for each in row["others"][:_MOST]]
        lines.append(row["ending"])
    else:
        often = f" ({cause['times']} times)" if cause["times"] > 1 else ""
        when = f"at {cause['time']:.2f} s (tick {cause['tick']})"
        lines.append(f"{when}, {cause['kind'].replace('_', ' ')}: {cause['sentence']}{often}.")
        lines += [f"  then at {_clause(each)}" for each in row["others"][:_MOST]]
    if patch := row.get("patch"):
        lines.append(("changed " if patch["applied"] else "would help: ") + patch["edit"])
        seeds = f"{patch['seeds']} fresh seeds"
        lines.append(f"  {seeds}: {patch['before']} succeeded before, {patch['after']} after")
    elif "tried" in row:
        lines.append(f"none of {row['tried']} tried changes raised the rate of success")
    return "\n".join([f"{heading}:", *(f"  {line}" for line in lines)])
