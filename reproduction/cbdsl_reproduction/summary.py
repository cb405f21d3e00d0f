"""Rows of the pages: counted by verdict, and grouped by the causes of their misses."""

from __future__ import annotations

import re
import textwrap
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources

from cbdsl_reproduction.quantity import Verdict

_HEADING = re.compile(r"^## ([^:\n]+): ", re.MULTILINE)
# An escaped bar belongs to the text of its cell.
_CELLS = re.compile(r"(?<!\\)\|")
# Default texts for rows without a recorded cause.
_DEFAULTS = {
    Verdict.MISSED: "cause not known",
    Verdict.UNDECIDED: "too few trials for a verdict",
    Verdict.ORDERING: "too few trials for more than the order",
}


@dataclass(frozen=True)
class PageRow:
    """Judged row of the page.

    Attributes:
        section: Heading of its section, such as ``fig-4.5 on bullet``.
        quantity: Name of the quantity, as on the page.
        ours: Number and its interval.
        verdict: Verdict, as on the page.
        source: Report of the source.
        expected: Region of its claim; empty if nothing is reported.
    """

    section: str
    quantity: str
    ours: str
    verdict: str
    source: str = ""
    expected: str = ""

    @property
    def hindsight(self) -> bool:
        """True if the region of its claim was set with known numbers."""
        return "(set in hindsight)" in self.expected


@dataclass(frozen=True)
class Cause:
    """Measured cause of a miss.

    Attributes:
        experiment: Experiment whose rows it explains.
        quantity: Part of their names; empty for all rows of the experiment.
        text: Cause, as a clause without capital and full stop.
    """

    experiment: str
    quantity: str
    text: str

    def explains(self, row: PageRow) -> bool:
        """Return whether it is the cause of a row's verdict."""
        return row.section.split()[0] == self.experiment and self.quantity in row.quantity


def rows_of(section: str) -> Iterator[PageRow]:
    """Yield the rows of the table of a section."""
    heading = _HEADING.search(section)
    table = [line for line in section.splitlines() if line.startswith("|")]
    if heading is None or len(table) < 2:
        return
    headings, *rest = (_cells(line) for line in table)
    for cells in rest[1:]:
        row = dict(zip(headings, cells, strict=True))
        names = ("quantity", "ours", "verdict", "source", "expected")
        yield PageRow(heading[1], *(row[name] for name in names))


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in _CELLS.split(line)[1:-1]]


def counts(heading: str, places: Mapping[str, str], rows: Sequence[PageRow]) -> Iterator[str]:
    """Yield sentences and the lines of a table that count the verdicts.

    Rows whose regions were set with known numbers are counted apart, below the others.

    Args:
        heading: Heading of the first column.
        places: Cell of the first column by section; equal cells share a line.
        rows: Counted rows.
    """
    # A region that was set with known numbers could hardly be
    # missed, so that it must not raise the share of the others.
    ahead, late = ([row for row in rows if row.hindsight is is_late] for is_late in (False, True))
    total = Counter(row.verdict for row in ahead)
    yield f"{_share(ahead)} are reproduced; {total[Verdict.NOT_JUDGED]} are not judged."
    if late:
        yield f"Of the rows with regions set in hindsight, {_share(late)} are reproduced."
    yield ""
    verdicts = [verdict.value for verdict in Verdict]
    yield f"| {heading} | {' | '.join(verdicts)} | set in hindsight |"
    yield f"|{' --- |' * (2 + len(verdicts))}"
    for place in dict.fromkeys(places.values()):
        count = Counter(row.verdict for row in ahead if places[row.section] == place)
        own = [row for row in late if places[row.section] == place]
        cells = [str(count[verdict]) for verdict in verdicts]
        yield f"| {place} | {' | '.join(cells)} | {_fraction(own) if own else ''} |"


def _fraction(rows: Sequence[PageRow]) -> str:
    """Return the number of reproduced rows, and of judged ones."""
    judged = [row for row in rows if row.verdict != Verdict.NOT_JUDGED]
    return f"{sum(row.verdict == Verdict.REPRODUCED for row in judged)} of {len(judged)}"


def _share(rows: Sequence[PageRow]) -> str:
    """Return the number of reproduced rows among the judged ones, with their share."""
    fraction = _fraction(rows)
    reproduced, _, judged = fraction.partition(" of ")
    share = 100 * int(reproduced) / int(judged) if int(judged) else 0.0
    return f"{fraction} judged rows ({share:.0f} %)"


def causes_of(rows: Sequence[PageRow]) -> list[str]:
    """Return a list of causes, each with the number of its rows in each section."""
    groups: dict[str, Counter[tuple[str, str]]] = {}
    for row in rows:
        if row.verdict in _DEFAULTS:
            groups.setdefault(_cause(row), Counter())[row.section, row.verdict] += 1
    return [_group(cause, count) for cause, count in groups.items()]


def _cause(row: PageRow) -> str:
    default = _DEFAULTS[Verdict(row.verdict)]
    # The first matching cause wins, so that the file
    # lists causes of single rows ahead of general ones.
    return next((each.text for each in causes() if each.explains(row)), default)


def _group(cause: str, count: Mapping[tuple[str, str], int]) -> str:
    places = ", ".join(
        f"{section} ({number} {verdict})" for (section, verdict), number in count.items()
    )
    return paragraph(f"* {places}: {cause}.", indent="  ")


def paragraph(text: str, indent: str = "") -> str:
    """Wrap a text of the page.

    Args:
        text: One paragraph or list item.
        indent: Indentation of all lines except the first.
    """
    return textwrap.fill(
        text, 115, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )


def causes() -> tuple[Cause, ...]:
    """Return the known causes, in order of precedence."""
    text = (resources.files(__package__) / "causes.toml").read_text(encoding="utf-8")
    return tuple(Cause(**entry) for entry in tomllib.loads(text)["cause"])
