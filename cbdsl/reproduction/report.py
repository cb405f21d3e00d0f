"""Outcomes as rows, as data, and as a page whose sections can be renewed one by one."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping

from cbdsl.reproduction.experiment import Experiment, Outcome, Settings
from cbdsl.reproduction.quantity import Quantity

_HEADER = """\
# Reproduction

What the dissertation reports, and what we measure. `cb reproduce all --out docs/reproduction.md`
writes this page, and `cb reproduce NAME --out docs/reproduction.md` renews one section of it.
Verdicts come from the rules in the column *expected*: **reproduced** where the rule holds,
**ordering only** where at least the reported order does, **missed** otherwise. Intervals are of
95 %: exact (Clopper-Pearson) for proportions, bootstrapped for means.
"""

_SECTION = re.compile(r"^## (\S+): ", re.MULTILINE)


def row(quantity: Quantity) -> dict[str, str]:
    """A quantity as texts, by the headings of a table."""
    return {
        "quantity": quantity.name,
        "source": quantity.source,
        "ours": _measured(quantity),
        "expected": quantity.expected.text,
        "verdict": quantity.verdict.value,
        "note": quantity.note,
    }


def data(experiment: Experiment, settings: Settings, outcome: Outcome) -> dict[str, object]:
    """An outcome for scripts; what could not be measured is ``None``."""
    return {
        "experiment": experiment.name,
        "title": experiment.title,
        "section": experiment.section,
        "seed": settings.seed,
        "quick": settings.quick,
        "quantities": [_quantity(quantity) for quantity in outcome.quantities],
        "charts": [
            {
                "name": chart.name,
                "title": chart.title,
                "x": chart.x_label,
                "y": chart.y_label,
                "lines": {line.name: [list(line.x), list(line.y)] for line in chart.lines},
            }
            for chart in outcome.charts
        ],
        "notes": list(outcome.notes),
    }


def section(experiment: Experiment, settings: Settings, outcome: Outcome, pictures: str) -> str:
    """The part of the page about one experiment; ``pictures`` is the folder of the charts."""
    rows = [row(quantity) for quantity in outcome.quantities]
    quick = " --quick" if settings.quick else ""
    headings = list(rows[0]) if rows else []
    table = [headings, ["---"] * len(headings), *(list(cells.values()) for cells in rows)]
    lines = [
        f"## {experiment.name}: {experiment.title}",
        "",
        f"{experiment.section}. `cb reproduce {experiment.name} --seed {settings.seed}{quick}`",
        "",
        *(f"| {' | '.join(_escaped(cell) for cell in cells)} |" for cells in table if cells),
        "",
    ]
    for note in outcome.notes:
        lines += [note, ""]
    for chart in outcome.charts:
        lines += [f"![{chart.title}]({pictures}/{chart.name}.svg)", ""]
    return "\n".join(lines)


def page(before: str, sections: Mapping[str, str], order: Iterable[str]) -> str:
    """The whole page.

    Args:
        before: the page so far, or nothing.
        sections: new text by the name of the experiment.
        order: of all experiments; sections of any others are left out.
    """
    marks = list(_SECTION.finditer(before))
    ends = [mark.start() for mark in marks[1:]] + [len(before)] * bool(marks)
    kept = {
        mark[1]: before[mark.start() : end].rstrip() + "\n"
        for mark, end in zip(marks, ends, strict=True)
    }
    kept.update(sections)
    return "\n".join([_HEADER, *(kept[name] for name in order if name in kept)])


def _quantity(quantity: Quantity) -> dict[str, object]:
    return {
        "name": quantity.name,
        "unit": quantity.unit,
        "source": quantity.source,
        "ours": None if math.isnan(quantity.ours) else quantity.ours,
        "interval": list(quantity.interval) if quantity.interval else None,
        "expected": quantity.expected.text,
        "verdict": quantity.verdict.value,
        "note": quantity.note,
    }


def _measured(quantity: Quantity) -> str:
    if math.isnan(quantity.ours):
        return "none"
    text = f"{quantity.ours:.3g}"
    if quantity.interval is not None:
        low, high = quantity.interval
        text += f" [{low:.3g}, {high:.3g}]"
    return f"{text} {quantity.unit}".rstrip()


def _escaped(cell: str) -> str:
    return cell.replace("|", "\\|")
