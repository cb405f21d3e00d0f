"""Measure the rows of docs/results.md, and write the page.

``python docs/make_results.py`` writes the page from the files that ``cb judge NAME --out results``
wrote. With ``--measure`` it first runs the judges of all missing and stale conditions; an
interrupted run goes on. ``results/page.toml`` lists the campaigns and rows.

A condition is stale if the code, its judge, its program or its knowledge has changed since. Rows of
stale conditions are left out of the page. Seeds derive from the same digests, so that a
change takes seeds that no choice can have used.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from cbdsl.api.documents import digest_of_text
from cbdsl.numeric.proportion import exact_interval
from cbdsl_reproduction.judges.judge import Judge, JudgedCondition
from cbdsl_reproduction.judges.registry import JUDGES
from cbdsl_reproduction.judges.row_digests import row_digests

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "results"
FILE = ROOT / "docs" / "results.md"
#: Seeds of this page, in blocks that no two campaigns share by chance alone.
SEEDS = range(70_000_000, 80_000_000)
_BLOCK = 1000

_HEAD = """\
# Results

Each row was measured with the control law, programs and knowledge of this version.
`make results` measures rows again after a change of them, and leaves out the others.
Intervals are exact (Clopper-Pearson, 95 %).
The interval of a Brier score is of its difference to the base rate.
[Judging seeds](seeds.md) derive from digests of the judged code, so that no choice has used them.
"Ideal" and "rendered" name the cameras of the [engines](how_to/choose_an_engine.md).
[Judges](how_to/judge_behaviour.md) know the truth of the simulated world; programs do not.
[Reproduction](reproduction/index.md) holds the results that the dissertation reports.
"""
_COLUMNS = ("condition", "result", "interval", "aim", "command")
Row = Mapping[str, Any]


class Campaign(NamedTuple):
    """Judge with its body and number of episodes, and rows of the page."""

    judge: Judge
    backend: str
    cameras: str
    episodes: int
    rows: Sequence[Row]

    @classmethod
    def read(cls, table: Mapping[str, Any]) -> Campaign:
        """Return a campaign of page.toml."""
        return cls(JUDGES[table["judge"]], *(table[key] for key in cls._fields[1:]))

    def conditions(self, row: Row) -> list[JudgedCondition]:
        """Return the conditions that a row sums."""
        named = row["conditions"]
        chosen = [each for each in self.judge.conditions if named == ["*"] or each.name in named]
        if named != ["*"] and len(chosen) != len(named):
            raise ValueError(f"page.toml: {self.judge.name} lacks a condition of {row['label']}")
        return chosen

    @property
    def shown(self) -> list[JudgedCondition]:
        """Conditions of all rows."""
        names = {condition.name for row in self.rows for condition in self.conditions(row)}
        return [each for each in self.judge.conditions if each.name in names]

    def valid(self, folder: Path) -> dict[str, list[Row]]:
        """Return the measured rows of conditions that are not stale, by name."""
        file = folder / f"{self.judge.name}.json"
        result = json.loads(file.read_text("utf-8")) if file.is_file() else {"rows": []}
        found: dict[str, list[Row]] = {}
        for row in result["rows"]:
            found.setdefault(row["condition"], []).append({**result, **row.get("run", {}), **row})
        return {
            each.name: found[each.name]
            for each in self.shown
            if each.name in found and self._holds(each, found[each.name])
        }

    def _holds(self, condition: JudgedCondition, rows: Sequence[Row]) -> bool:
        """Return whether rows were measured as the campaign has it, with the present software."""
        setting = {
            "backend": self.backend,
            "cameras": self.cameras,
            "episodes": self.episodes,
            "digests": row_digests(self.judge, condition, self.backend),
        }
        return all({key: row.get(key) for key in setting} == setting for row in rows)

    def command(self, conditions: Sequence[JudgedCondition]) -> list[str]:
        """Return the words of the command that measures some conditions."""
        words = ["judge", self.judge.name, "--seed", str(self._seed(conditions))]
        words += ["--episodes", str(self.episodes), "--backend", self.backend]
        words += ["--cameras", self.cameras, "--out", str(FOLDER), "--resume", "--workers", "2"]
        if len(conditions) < len(self.judge.conditions):
            for condition in conditions:
                words += ["--only", condition.name]
        return words

    def _seed(self, conditions: Sequence[JudgedCondition]) -> int:
        """Return a seed that depends on all that is judged."""
        digests = [row_digests(self.judge, each, self.backend) for each in conditions]
        number = int(digest_of_text(json.dumps([self[1:4], digests])), 16)
        return SEEDS.start + number % (len(SEEDS) // _BLOCK) * _BLOCK


def measure(folder: Path = FOLDER) -> None:
    """Run the judges of all conditions that are missing or stale."""
    folder.mkdir(exist_ok=True)
    for campaign in _campaigns():
        valid = campaign.valid(folder)
        stale = [each for each in campaign.shown if each.name not in valid]
        if stale:
            words = campaign.command(stale)
            sys.stdout.write(f"+ cb {' '.join(words)}\n")
            sys.stdout.flush()
            # A missed aim is a result; an interrupt ends the campaigns.
            code = subprocess.run([str(Path(sys.executable).with_name("cb")), *words]).returncode
            if code not in (0, 1):
                raise SystemExit(code)
            FILE.write_text(page(folder), "utf-8")


def page(folder: Path = FOLDER) -> str:
    """Return the page."""
    return "\n".join([_HEAD, *("\n".join(_section(each, folder)) for each in _sections())])


def _sections() -> list[Mapping[str, Any]]:
    sections: list[Mapping[str, Any]] = tomllib.loads(
        (FOLDER / "page.toml").read_text("utf-8")
    )["section"]  # fmt: skip
    return sections


def _campaigns() -> Iterator[Campaign]:
    for section in _sections():
        yield from map(Campaign.read, section["campaign"])


def _section(section: Mapping[str, Any], folder: Path) -> Iterator[str]:
    """Yield the lines of one section."""
    yield f"## {section['title']}\n"
    if section.get("notes"):
        yield from (*section["notes"], "")
    lines, count = [], 0
    for campaign in map(Campaign.read, section["campaign"]):
        valid = campaign.valid(folder)
        last = None
        for row in campaign.rows:
            names = [condition.name for condition in campaign.conditions(row)]
            if not all(name in valid for name in names):
                count += 1
                continue
            cells, command = _cells(row, [valid[name] for name in names])
            lines.append(_line([*cells, command if command != last else ""]))
            last = command
    if lines:
        yield from (_line(_COLUMNS), _line(["---"] * len(_COLUMNS)), *lines, "")
    if count:
        yield f"Not yet measured with this version: {count} row{'s' * (count > 1)}.\n"


def _cells(row: Row, conditions: Sequence[Sequence[Row]]) -> tuple[list[str], str]:
    """Return the cells of a row, and the command that measured it."""
    rows = [each for rows in conditions for each in rows if each["outcome"] == row["outcome"]]
    first = rows[0]
    command = f"`{_short(first['command'])}` ({(first['commit'] or 'no commit')[:8]})"
    low, high = first["interval"]
    if "result" in first:
        return [row["label"], first["result"], f"[{low:.3f}, {high:.3f}]", first["aim"]], command
    successes, count = (sum(each[key] for each in rows) for key in ("successes", "n"))
    if not count:
        return [row["label"], "0 of 0", "", first["aim"]], command
    low, high = (f"{100 * end:.1f}".removesuffix(".0") for end in exact_interval(successes, count))
    aim = first["aim"].removeprefix("at least ")
    return [row["label"], f"{successes} of {count}", f"[{low}, {high}] %", aim], command


def _short(command: str) -> str:
    """Return a command without the names of single conditions."""
    return command.split(" --only ")[0]


def _line(cells: Sequence[str]) -> str:
    """Return a line of a table."""
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    if "--measure" in sys.argv[1:]:
        measure()
    FILE.write_text(page(), "utf-8")
    sys.stdout.write(f"{FILE}\n")
