"""Pages of the outcomes: one for each chapter of the source, and a summary of all."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from cbdsl_reproduction.experiment import Experiment
from cbdsl_reproduction.summary import causes_of, counts, rows_of

#: File of the summary.
SUMMARY = "index.md"

_HEADER = """\
# Reproduction

These pages hold the results that the dissertation reports, beside ours, one page for each chapter.
`cb reproduce all --out docs/reproduction` writes them.
`cb reproduce NAME --out docs/reproduction` renews one section.

The column *expected* is the region in which the source's words put a value.
The verdict follows from the 95 % interval of our value:

| verdict | meaning |
| --- | --- |
| reproduced | all of the interval is in the region |
| missed | none of it is in the region |
| undecided | a part of it is in the region |
| ordering only | at least the reported order is clear, and a part of it is in the region |
| not judged | there is no spread to judge by (one trial), or nothing is claimed |

The column *chance* is the probability that a claim that is just false would be called reproduced.
Above 5 % nothing is called reproduced.
A coin, or a uniform model, passes at most as often if the claim is false for it.
For curves, ratios and newly drawn trials it is the 2.5 % of the intervals.
Regions that were set with known numbers say so, and their rows are counted apart.
Intervals are exact (Clopper-Pearson) for proportions.
If several outcomes come from one trial, they use the effective number of outcomes (Korn-Graubard).
All other intervals are bootstrapped.
Robots learn on the kinematic backend, many times from zero; other backends have separate sections.
"""

# The list of causes is no section of an experiment, but is derived from the rows of all sections.
_SECTION = re.compile(r"^## ((?!Not reproduced)[^:\n]+): ", re.MULTILINE)


def page_of(experiment: Experiment) -> str:
    """Return the name of an experiment's page: its chapter, or its own name without a chapter."""
    chapter = re.match(r"Sections? (\d+)", experiment.section)
    return f"chapter_{chapter[1]}" if chapter else experiment.name


def title_of(page: str) -> str:
    """Return the title of a page."""
    return page.replace("_", " ").capitalize()


def chapter_page(
    name: str, before: str, sections: Mapping[str, str], order: Iterable[Experiment]
) -> str:
    """Return the page of a chapter.

    Args:
        name: Name of the page, from ``page_of``.
        before: Existing page, or an empty text.
        sections: New text by its heading.
        order: All experiments; sections of others are removed.
    """
    # A run of one experiment keeps the sections of all others.
    kept = _sections(before) | dict(sections)
    own = [each.name for each in order if page_of(each) == name]
    # Sections of other backends follow the section of the default one.
    texts = [kept[each] for word in own for each in sorted(kept) if each.split()[0] == word]
    rows = [row for text in texts for row in rows_of(text)]
    head = [
        f"# Reproduction: {title_of(name)}",
        "",
        f"The [summary]({SUMMARY}) explains the columns.",
        "",
        *counts("section", {row.section: row.section for row in rows}, rows),
        "",
    ]
    missing = causes_of(rows)
    listed = ["## Not reproduced", "", *missing, ""] if missing else []
    return "\n".join([*head, *listed, *texts])


def summary_page(pages: Mapping[str, str]) -> str:
    """Return the summary: the counts of each chapter, and the misses by their causes.

    Comparisons of engines are not of the source, so that they do not count.

    Args:
        pages: Text of each page by its name.
    """
    places, rows = {}, []
    for name, text in pages.items():
        link = f"[{title_of(name)}]({name}.md)"
        for section in _sections(text).values():
            added = list(rows_of(section))
            rows += added
            places.update({row.section: link for row in added})
    misses = [row for row in rows if row.verdict == "missed"]
    claims = [row for row in rows if not row.section.startswith("engines")]
    places = {row.section: places[row.section] for row in claims}
    lines = [_HEADER, "## Summary", "", *counts("page", places, claims), ""]
    if len(claims) < len(rows):
        lines += ["[Engines](engines.md) compares our backends, apart from the source.", ""]
    return "\n".join([*lines, "Misses by cause; the pages list the undecided rows, too:", "",
                      *causes_of(misses), ""])  # fmt: skip


def existing_pages(folder: Path, experiments: Iterable[Experiment]) -> dict[str, str]:
    """Return the texts of the existing pages of a folder by name, in the order of the source."""
    names = dict.fromkeys(map(page_of, experiments))
    files = {name: folder / f"{name}.md" for name in names}
    return {name: file.read_text("utf-8") for name, file in files.items() if file.exists()}


def _sections(page: str) -> dict[str, str]:
    """Return the sections of a page by their headings."""
    marks = list(_SECTION.finditer(page))
    ends = [mark.start() for mark in marks[1:]] + [len(page)] * bool(marks)
    return {
        mark[1]: page[mark.start() : end].rstrip() + "\n"
        for mark, end in zip(marks, ends, strict=True)
    }
