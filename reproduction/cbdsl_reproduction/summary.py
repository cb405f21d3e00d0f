"""Summary of the page: verdicts counted by section, and each miss with its cause."""

from __future__ import annotations

import re
import textwrap
import tomllib
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import resources

from cbdsl_reproduction.quantity import Verdict

_HEADING = re.compile(r"^## ([^:\n]+): ", re.MULTILINE)
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
    """

    section: str
    quantity: str
    ours: str
    verdict: str


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


def summary(sections: Sequence[str]) -> str:
    """Return the counts by section, and each row that is not reproduced with its cause.

    Args:
        sections: Texts of the sections of the page, in order.
    """
    rows = [row for section in sections for row in rows_of(section)]
    judged = [row for row in rows if row.verdict != Verdict.NOT_JUDGED]
    count = Counter(row.verdict for row in rows)
    share = 100 * count[Verdict.REPRODUCED] / len(judged) if judged else 0.0
    lines = [
        "## Summary",
        "",
        f"{count[Verdict.REPRODUCED]} of {len(judged)} judged rows are reproduced ({share:.0f} %); "
        f"{count[Verdict.NOT_JUDGED]} are not judged.",
        "",
        *_counts(rows),
        "",
        *(_miss(row) for row in rows if row.verdict in _DEFAULTS),
        "",
    ]
    return "\n".join(lines)


def rows_of(section: str) -> Iterator[PageRow]:
    """Yield the rows of the table of a section."""
    heading = _HEADING.search(section)
    table = [line for line in section.splitlines() if line.startswith("|")]
    if heading is None or len(table) < 2:
        return
    headings, *rest = (_cells(line) for line in table)
    for cells in rest[1:]:
        row = dict(zip(headings, cells, strict=True))
        yield PageRow(heading[1], row["quantity"], row["ours"], row["verdict"])


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in _CELLS.split(line)[1:-1]]


def _counts(rows: Sequence[PageRow]) -> Iterator[str]:
    """Yield the lines of a table with a row for each section."""
    verdicts = [verdict.value for verdict in Verdict]
    yield f"| section | {' | '.join(verdicts)} |"
    yield f"|{' --- |' * (1 + len(verdicts))}"
    for section in dict.fromkeys(row.section for row in rows):
        count = Counter(row.verdict for row in rows if row.section == section)
        yield f"| {section} | {' | '.join(str(count[verdict]) for verdict in verdicts)} |"


def paragraph(text: str, indent: str = "") -> str:
    """Wrap a text of the page.

    Args:
        text: One paragraph or list item.
        indent: Indentation of all lines except the first.
    """
    return textwrap.fill(
        text, 115, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )


def _miss(row: PageRow) -> str:
    default = _DEFAULTS[Verdict(row.verdict)]
    cause = next((each.text for each in causes() if each.explains(row)), default)
    text = f"* {row.section}, {row.quantity}: {row.ours}, {row.verdict}; {cause}."
    return paragraph(text, indent="  ")


def causes() -> tuple[Cause, ...]:
    """Return the known causes, in order of precedence."""
    text = (resources.files(__package__) / "causes.toml").read_text(encoding="utf-8")
    return tuple(Cause(**entry) for entry in tomllib.loads(text)["cause"])
