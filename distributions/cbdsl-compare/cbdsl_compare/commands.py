"""``cb compare``: paired episodes of two programs, policies, robots or revisions of documents."""

from __future__ import annotations

import json
import re
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import typer

from cbdsl import RunRequest, UsageError, load
from cbdsl.extend.command import (
    Cameras,
    Json,
    default_engine,
    read_assignments,
)
from cbdsl_compare.comparison import EpisodePair, ProgramComparison
from cbdsl_compare.comparison import compare as compare_programs
from cbdsl_compare.revision import written_revision
from cbdsl_why.recorded_episodes import diagnosed, diagnosis_row, recorded_episodes

_SIDE = "PROGRAM or PROGRAM@REVISION, with options behind commas: reach@HEAD~1,stage=absent."
First = Annotated[str, typer.Argument(metavar="A", help=_SIDE)]
Second = Annotated[str, typer.Argument(metavar="B", help="The program to compare with it.")]
Seeds = Annotated[str, typer.Option("--seeds", help="First and last seed.")]
All = Annotated[
    bool, typer.Option("--all", help="Run all seeds, even when the difference is decided.")
]
Markdown = Annotated[
    bool, typer.Option("--markdown", help="Print a table, such as for $GITHUB_STEP_SUMMARY.")
]

#: Exit code of a second program that is decidedly worse.
_WORSE = 3
# Options of a side that are no parameters of its program.
_OPTIONS = ("stage", "policy", "schema", "backend")


def compare(
    first: First,
    second: Second,
    seeds: Seeds = "0-99",
    cameras: Cameras = None,
    every: All = False,
    as_json: Json = False,
    markdown: Markdown = False,
) -> None:
    """Compare the success rates of two programs, policies or robots with the same seeds.

    A and B are programs, each with its own stage, policy, schema, backend and parameters.
    PROGRAM@REVISION takes the program and all its documents from a git revision, and runs them with
    the installed code, such as reach@HEAD~1. The interval of 95 % holds at all numbers of pairs.
    The comparison ends when it is decided, or when the remaining seeds cannot decide it. The first
    seed with one success is explained as by cb why.

    Exit 0, or 3 if B is decidedly worse. Exit 1 if a document has errors, and 2 if a program cannot
    run.
    """
    if as_json and markdown:
        raise UsageError("--json and --markdown exclude each other")
    names = (first, second)
    with TemporaryDirectory() as a, TemporaryDirectory() as b:
        sides = [_read(text, Path(folder)) for text, folder in zip(names, (a, b), strict=True)]
        compared = compare_programs(
            sides[0][0],
            sides[1][0],
            seeds=_range(seeds),
            backends=(sides[0][1], sides[1][1]),
            cameras=cameras,
            stops_early=not every,
            on_pair=None if as_json or markdown else _print,
        )
        why = _why(compared, sides, cameras)
    if as_json:
        print(json.dumps(_row(compared, names, why), ensure_ascii=False))
    elif markdown:
        print(_table(compared, names, why))
    else:
        print("\n".join(_lines(compared, names, why)))
    if compared.interval[1] < 0.0:
        raise typer.Exit(_WORSE)


def _read(text: str, target: Path) -> tuple[RunRequest, str | None]:
    """Return the request and the backend of a side; a folder receives its revision, if any."""
    written, *words = text.split(",")
    program, folder = written_revision(written, target)
    values = read_assignments(words, option=written)
    stage, policy, schema, backend = (values.pop(name, None) for name in _OPTIONS)
    request = load(program, stage=stage, policy=policy, schema=schema, values=values, folder=folder)
    return request, backend


def _range(seeds: str) -> range:
    match = re.fullmatch(r"(\d{1,9})-(\d{1,9})", seeds)
    if match is None or int(match[1]) > int(match[2]):
        raise UsageError(
            f"--seeds {seeds}: expected the first and the last seed, such as 0-99, of at most 9 "
            "digits"
        )
    return range(int(match[1]), int(match[2]) + 1)


def _print(pair: EpisodePair) -> None:
    words = ["yes" if each else "no" for each in pair.successes]
    print(f"  seed {pair.seed}: A {words[0]}, B {words[1]}", flush=True)


def _why(
    compared: ProgramComparison, sides: list[tuple[RunRequest, str | None]], cameras: str | None
) -> dict[str, Any] | None:
    """Return the first cause of the failed one of the first pair that differs."""
    pair = compared.first_differing
    if pair is None:
        return None
    failed = int(pair.successes[0])
    request, backend = sides[failed]
    with TemporaryDirectory() as folder:
        recorded = recorded_episodes(
            request, backend or default_engine(), cameras, (pair.seed,), Path(folder)
        )
        (row,) = [diagnosis_row(*diagnosed(file)) for file in recorded]
    cause = row["cause"]
    reason = "I do not know" if cause is None else f"{cause['kind']}: {cause['sentence']}"
    return {"seed": pair.seed, "failed": "AB"[failed], "why": reason, "cause": cause}


def _verdict(compared: ProgramComparison) -> str:
    ran = len(compared.pairs)
    if compared.is_decided:
        better = "B" if compared.difference > 0.0 else "A"
        return f"{better} succeeds more often, decided after {ran} of {compared.requested} seeds"
    return f"undecided after {ran} of {compared.requested} seeds"


def _difference(compared: ProgramComparison) -> str:
    low, high = (100 * end for end in compared.interval)
    return f"{100 * compared.difference:+.1f} % ({low:+.1f} to {high:+.1f} %)"


def _lines(
    compared: ProgramComparison, names: tuple[str, str], why: dict[str, Any] | None
) -> list[str]:
    ran, counts, only = len(compared.pairs), compared.counts, compared.only
    lines = [f"{'AB'[n]} {names[n]}: {counts[n]} of {ran}, alone {only[n]}" for n in (0, 1)]
    lines.append(f"B - A: {_difference(compared)}; {_verdict(compared)}")
    if why is not None:
        lines.append(f"first difference: seed {why['seed']}, {why['failed']} failed, {why['why']}")
    return lines


def _table(compared: ProgramComparison, names: tuple[str, str], why: dict[str, Any] | None) -> str:
    """Return the comparison as a table in Markdown."""
    ran, counts = len(compared.pairs), compared.counts
    cells = [*(f"{counts[n]} of {ran}" for n in (0, 1)), _difference(compared)]
    lines = [f"| A: {names[0]} | B: {names[1]} | B - A | |", "| --- | --- | --- | --- |"]
    lines.append(f"| {' | '.join(cells)} | {_verdict(compared)} |")
    if why is not None:
        clause = why["why"].replace("|", "\\|")
        lines += ["", f"First difference: seed {why['seed']}, {why['failed']} failed, {clause}."]
    return "\n".join(lines)


def _row(
    compared: ProgramComparison, names: tuple[str, str], why: dict[str, Any] | None
) -> dict[str, Any]:
    """Return the comparison as JSON data."""
    return {
        "a": names[0],
        "b": names[1],
        "seeds": [pair.seed for pair in compared.pairs],
        "requested": compared.requested,
        "successes": compared.counts,
        "alone": compared.only,
        "difference": compared.difference,
        "interval": compared.interval,
        "p_value": compared.p_value if len(compared.pairs) == compared.requested else None,
        "decided": compared.is_decided,
        "first_difference": why,
    }
