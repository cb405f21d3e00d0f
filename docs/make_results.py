"""Make docs/results.md from the files in results/.

Run ``python docs/make_results.py`` after a change of these files. A file with a ``capability``
holds the rows of one table. A row has a count (``successes`` of ``n``) or a text (``result``). A
file that ``cb judge NAME --out results`` wrote replaces the rows with this ``judge``.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from cbdsl.numeric.proportion import exact_interval

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "results"
FILE = ROOT / "docs" / "results.md"

_HEAD = """\
# Results

Each table holds the newest judged numbers of a capability.
Intervals are exact (Clopper-Pearson, 95 %) unless stated otherwise.
A command, with its commit, stands in the first of its rows.
Rows without commit are of the first-order control law (commit 55090bcb).
[`cb judge NAME`](how_to/judge_behaviour.md) replaces some named scripts.
Seeds from 7000000 are [judging seeds](seeds.md).
No listed seed influenced a choice, except where a remark says so.
The machine has two shared cores and no GPU.
"Ideal" and "rendered" name the cameras of the [engines](how_to/choose_an_engine.md).
[Reproduction](reproduction/index.md) holds the results that the dissertation reports.
"""
_COLUMNS = ("condition", "result", "interval", "aim", "command")


def page(folder: Path = FOLDER) -> str:
    """Return the page."""
    files = [json.loads(file.read_text("utf-8")) for file in sorted(folder.glob("*.json"))]
    judged = {file["judge"]: file for file in files if "judge" in file}
    capabilities = [file for file in files if "capability" in file]
    capabilities.sort(key=lambda file: file["order"])
    sections = ["\n".join(_section(file, judged)) for file in capabilities]
    return "\n".join([_HEAD, *sections])


def _section(file: Mapping[str, Any], judged: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of one capability."""
    yield f"## {file['capability']}\n"
    yield from file["notes"]
    if file["notes"]:
        yield ""
    yield _line(_COLUMNS)
    yield _line(["---"] * len(_COLUMNS))
    yield from _table(list(_rows(file["rows"], judged)))
    if file["remarks"]:
        yield ""
    yield from file["remarks"]
    yield ""


def _rows(
    rows: Sequence[Mapping[str, Any]], judged: Mapping[str, Any]
) -> Iterator[Mapping[str, Any]]:
    """Yield the rows; those of a judge's own file stand at the place of its first row."""
    replaced = set()
    for row in rows:
        name = row.get("judge")
        if name not in judged:
            yield row
        elif name not in replaced:
            replaced.add(name)
            yield from _judged(judged[name])


def _judged(file: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """Yield the outcomes with aims of a judge's file, and sums of undesired ones."""
    none: dict[str, list[Mapping[str, Any]]] = {}
    for row in file["rows"]:
        if row["aim"] == "none":
            none.setdefault(row["outcome"], []).append(row)
        elif row["aim"]:
            yield {
                **row,
                **_setting(row, file),
                "condition": f"{row['condition']}: {row['outcome']}",
            }
    for outcome, rows in none.items():
        successes, count = (sum(row[key] for row in rows) for key in ("successes", "n"))
        total = {"successes": successes, "n": count, "interval": exact_interval(successes, count)}
        yield {**rows[-1], **_setting(rows[-1], file), **total, "condition": outcome}


def _setting(row: Mapping[str, Any], file: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the command of a row, with its commit and seed."""
    # A row of an earlier run holds the command of that run.
    run = row.get("run", file)
    return {key: run[key] for key in ("command", "commit", "seed")}


def _table(rows: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield the lines of the rows; a command is printed in the first of successive rows."""
    last = None
    for row in rows:
        command = _command(row)
        yield _line([*_cells(row), command if command != last else ""])
        last = command


def _cells(row: Mapping[str, Any]) -> list[str]:
    """Return condition, result, interval and aim of a row."""
    if "result" in row:
        return [row["condition"], row["result"], "", row["aim"]]
    low, high = (f"{100 * end:.1f}".removesuffix(".0") for end in row["interval"])
    count = f"{row['successes']} of {row['n']}"
    return [row["condition"], count, f"[{low}, {high}] %", row["aim"].removeprefix("at least ")]


def _command(row: Mapping[str, Any]) -> str:
    """Return a command with the commit that ran it, if these are known."""
    seed = f", seed {row['seed']}" if "seed" in row else ""
    words = f"`{row['command']}`" if row["command"] else f"not recorded{seed}"
    return f"{words} ({row['commit'][:8]})" if row["commit"] else words


def _line(cells: Sequence[str]) -> str:
    """Return a line of a table."""
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    FILE.write_text(page(), "utf-8")
    sys.stdout.write(f"{FILE}\n")
