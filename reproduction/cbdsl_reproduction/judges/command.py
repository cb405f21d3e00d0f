"""``cb judge``: measure a capability of the shipped programs by the world's truth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cbdsl.extend.command import Cameras, Json

if TYPE_CHECKING:
    from cbdsl_reproduction.judges.judge import Judge, JudgedCondition
    from cbdsl_reproduction.judges.judging import Campaign, Verdicts

Name = Annotated[str | None, typer.Argument(help="Judge; see --list.")]
ListThem = Annotated[bool, typer.Option("--list", help="List the judges.")]
Seed = Annotated[
    int, typer.Option("--seed", min=0, help="Seed of the first episode of each condition.")
]
Episodes = Annotated[
    int | None,
    typer.Option("--episodes", min=1, help="Number of episodes of each condition [the judge's]."),
]
Only = Annotated[
    list[str] | None,
    typer.Option("--only", help="Condition to measure [all]; may be repeated."),
]
Task = Annotated[
    list[str] | None,
    typer.Option("--task", help="Task of robosuite [all]; may be repeated."),
]
Arm = Annotated[
    list[str] | None,
    typer.Option("--arm", help="Arm of robosuite [all]; may be repeated."),
]
BackendName = Annotated[
    str | None, typer.Option("--backend", help="Name of the backend [the judge's].")
]
Workers = Annotated[
    int,
    typer.Option(
        "--workers", min=1, help="Number of parallel processes; the result does not depend on it."
    ),
]
Out = Annotated[
    Path | None,
    typer.Option("--out", help="Folder for NAME.json, in which only measured rows are replaced."),
]
Resume = Annotated[
    bool,
    typer.Option("--resume", help="Keep the conditions that --out has of the same run."),
]


def judge(
    name: Name = None,
    *,
    list_them: ListThem = False,
    seed: Seed = 20_000,
    episodes: Episodes = None,
    only: Only = None,
    task: Task = None,
    arm: Arm = None,
    backend: BackendName = None,
    cameras: Cameras = None,
    workers: Workers = 1,
    out: Out = None,
    resume: Resume = False,
    as_json: Json = False,
) -> None:
    """Count successes of the shipped programs by the truth of the simulated world.

    No program sees this truth. Shares have exact (Clopper-Pearson) 95 % intervals. With --out, each
    finished condition is written immediately, and --resume continues an interrupted run.

    Exit 0 if all aims are met, 1 if one is missed, 2 if it cannot run.
    """
    from cbdsl import UsageError
    from cbdsl.extend.command import print_json, require_workers
    from cbdsl_reproduction.judges.judge import BodyChoice
    from cbdsl_reproduction.judges.judging import Campaign
    from cbdsl_reproduction.judges.registry import JUDGES

    if list_them:
        _list(as_json)
        return
    require_workers(workers)
    if name is None:
        raise UsageError("which judge? cb judge --list names them")
    if name not in JUDGES:
        raise UsageError.unknown("judge", name, JUDGES)
    chosen = JUDGES[name]
    campaign = Campaign(
        chosen,
        _conditions(chosen, only, {"task": task or [], "arm": arm or []}),
        BodyChoice(backend or chosen.body.backend, _cameras(chosen, backend, cameras)),
        seed,
        episodes or chosen.episodes,
    )
    if resume and out is None:
        raise UsageError("--resume: which results? name their folder by --out")
    if out is not None:
        _require_writable(out, name)
    result = _result(campaign, workers, out, resume=resume)
    if as_json:
        print_json(result)
    else:
        _tell(result)
    if not result["met"]:
        raise typer.Exit(1)


def _cameras(judge: Judge, backend: str | None, cameras: str | None) -> str | None:
    """Return the kind of cameras: given, or the judge's own on its own backend."""
    own = backend is None or backend == judge.body.backend
    return cameras or (judge.body.cameras if own else None)


def _conditions(
    judge: Judge, only: list[str] | None, parts: Mapping[str, list[str]]
) -> tuple[JudgedCondition, ...]:
    """Return the conditions to measure.

    Args:
        judge: Judge.
        only: Names of conditions; all if empty.
        parts: Parts of the names of conditions, by the option that selects them, in order.

    Raises:
        UsageError: The judge has no such condition.
    """
    from cbdsl import UsageError

    chosen = judge.conditions
    for place, (option, words) in enumerate(parts.items()):
        part = {each.name: "".join(each.name.split(", ")[place:][:1]) for each in chosen}
        known = sorted({*part.values()} - {""})
        for word in words:
            if word not in known:
                raise UsageError.unknown(f"{option} of {judge.name}", word, known)
        chosen = tuple(each for each in chosen if not words or part[each.name] in words)
    names = [condition.name for condition in judge.conditions]
    for name in only or ():
        if name not in names:
            raise UsageError.unknown(f"condition of {judge.name}", name, names)
    return tuple(each for each in chosen if not only or each.name in only)


def _result(campaign: Campaign, workers: int, out: Path | None, *, resume: bool) -> dict[str, Any]:
    """Return the result of a campaign, some of whose conditions a file may have already."""
    from cbdsl_reproduction.judges.kept_result import measured_alike, read_result
    from cbdsl_reproduction.judges.result import digests_in, result_of, run_of

    file = None if out is None else out / f"{campaign.judge.name}.json"
    known = read_result(file) if file is not None and resume else None
    digests = {each.name: digests_in(campaign, each) for each in campaign.conditions}
    kept = measured_alike(known, run_of(campaign), digests) if known else ()
    rest = tuple(each for each in campaign.conditions if each.name not in kept)
    if rest:
        campaign_left = replace(campaign, conditions=rest)
        result = result_of(campaign_left, _run(campaign_left, workers, out))
        if out is not None:
            _write(out, result)
        if not kept:
            return result
    assert file is not None
    whole = read_result(file) or {}
    names = [condition.name for condition in campaign.conditions]
    rows = [row for row in whole["rows"] if row["condition"] in names]
    return {**whole, "met": all(row["met"] for row in rows), "rows": rows}


def _run(campaign: Campaign, workers: int, out: Path | None) -> Verdicts:
    """Return the verdicts of a campaign, and write each finished condition."""
    from cbdsl.extend.command import (
        Progress,
        print_problem,
        shown_on_failure,
        termination_interrupts,
    )
    from cbdsl_reproduction.judges.result import result_of

    title, count, total = campaign.judge.name, 0, len(campaign.conditions)

    def finished(condition: JudgedCondition, verdicts: Verdicts) -> None:
        nonlocal count
        if out is not None:
            _write(out, result_of(replace(campaign, conditions=(condition,)), verdicts))
            count += 1

    try:
        with termination_interrupts(), shown_on_failure(), Progress(title) as progress:
            return campaign.run(workers, progress.note, finished)
    except KeyboardInterrupt:
        file = None if out is None else out / f"{title}.json"
        print_problem(
            "interrupted; no result is kept without --out"
            if file is None
            else f"interrupted; {file} has {count} of {total} conditions; --resume continues"
        )
        raise


def _list(as_json: bool) -> None:
    from cbdsl.extend.command import print_json
    from cbdsl_reproduction.judges.registry import JUDGES

    rows: list[dict[str, Any]] = [
        {
            "judge": judge.name,
            "title": judge.title,
            "conditions": [condition.name for condition in judge.conditions],
            "programs": list(judge.programs),
            "episodes": judge.episodes,
        }
        for judge in JUDGES.values()
    ]
    if as_json:
        print_json(rows)
        return
    _print_rows(
        "Judges",
        [{"judge": row["judge"], "title": row["title"], "episodes": str(row["episodes"])}
         for row in rows],
    )  # fmt: skip


def _tell(result: dict[str, Any]) -> None:
    """Print a line for each condition and outcome."""
    rows = []
    for row in result["rows"]:
        is_score = "result" in row
        factor, unit = (1, "") if is_score else (100, " %")
        low, high = (f"{factor * end:.{3 if is_score else 1}f}" for end in row["interval"])
        rows.append(
            {
                "condition": row["condition"],
                "outcome": row["outcome"],
                "count": row["result"] if is_score else f"{row['successes']} of {row['n']}",
                "interval": f"{low} to {high}{unit}",
                "aim": row["aim"],
                "verdict": "" if not row["aim"] else "met" if row["met"] else "missed",
            }
        )
    _print_rows(f"{result['judge']}: {result['title']}", rows)


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


def _require_writable(out: Path, name: str) -> None:
    """Check before the episodes that the result can be written, or joined to the kept one.

    Raises:
        UsageError: The folder cannot be created, or a file is in the way.
    """
    from cbdsl import UsageError
    from cbdsl.extend.command import reason
    from cbdsl_reproduction.judges.kept_result import read_result

    try:
        out.mkdir(parents=True, exist_ok=True)
        read_result(out / f"{name}.json")
    except OSError as error:
        raise UsageError(f"--out {out}: cannot be written ({reason(error)})") from error


def _write(out: Path, result: dict[str, Any]) -> None:
    import json

    from cbdsl.api.documents import write_text
    from cbdsl_reproduction.judges.kept_result import merged, read_result

    file = out / f"{result['judge']}.json"
    known = read_result(file)
    whole = result if known is None else merged(result, known)
    write_text(json.dumps(whole, indent=1, ensure_ascii=False) + "\n", file)
