"""Outcomes as rows, as data, and as sections of a page."""

from __future__ import annotations

import math

from cbdsl_reproduction.claim import Claim
from cbdsl_reproduction.experiment import Experiment, Picture, Result, RunSettings
from cbdsl_reproduction.quantity import Quantity, Verdict
from cbdsl_reproduction.summary import paragraph


def row(quantity: Quantity) -> dict[str, str]:
    """Return a quantity as texts, by the headings of a table."""
    return {
        "quantity": quantity.name,
        "source": quantity.claim.report,
        "ours": _measured(quantity),
        "expected": quantity.expected.text if quantity.expected else "",
        "chance": _chance(quantity),
        "verdict": quantity.verdict.value,
        "note": quantity.note,
    }


def claim_row(claim: Claim) -> dict[str, str]:
    """Return a claim as texts, by the headings of a table."""
    region = "" if claim.region is None else claim.region.text
    return {
        "section": claim.place,
        "quantity": claim.name,
        "unit": claim.unit,
        "source": claim.report,
        "expected": region,
        "rule": claim.rule.value,
    }


def data(experiment: Experiment, settings: RunSettings, outcome: Result) -> dict[str, object]:
    """Return an outcome for scripts; unmeasured values are ``None``."""
    keys = ("backend", "cameras", "trials")
    learned = {key: getattr(settings, key) for key in keys} if experiment.learns else {}
    learned |= {"trials": settings.trials} if experiment.keeps else {}
    return {
        "experiment": experiment.name,
        "title": experiment.title,
        "section": experiment.section,
        "seed": settings.seed,
        "quick": settings.quick,
        **learned,
        "quantities": [_quantity(quantity) for quantity in outcome.quantities],
        "charts": [
            {"name": chart.name, "title": chart.title, **chart.data()} for chart in outcome.charts
        ],
        "notes": list(outcome.notes),
    }


def section(experiment: Experiment, settings: RunSettings, outcome: Result) -> str:
    """Return the section of one experiment; its charts are beside the page."""
    rows = [row(quantity) for quantity in outcome.quantities]
    headings = list(rows[0]) if rows else []
    table = [headings, ["---"] * len(headings), *(list(cells.values()) for cells in rows)]
    lines = [
        f"## {heading(experiment, settings)}: {experiment.title}",
        "",
        f"{experiment.section}. `{_command(experiment, settings)}`",
        "",
        *(f"| {' | '.join(_escaped(cell) for cell in cells)} |" for cells in table if cells),
        "",
    ]
    for note in outcome.notes:
        lines += [paragraph(note), ""]
    for chart in outcome.charts:
        file = picture_file(chart, experiment, settings)
        lines += [f"[![{chart.title}]({file})]({file})", ""]
    return "\n".join(lines)


def picture_file(picture: Picture, experiment: Experiment, settings: RunSettings) -> str:
    """Return the file name of a picture, which is unique among all sections."""
    # A link has no spaces.
    backend = _other_backend(experiment, settings).replace(" ", "-")
    return f"{picture.name}-{backend}.svg" if backend else f"{picture.name}.svg"


def heading(experiment: Experiment, settings: RunSettings) -> str:
    """Return the heading of a section; an experiment has one section for each backend."""
    backend = _other_backend(experiment, settings)
    return f"{experiment.name} on {backend}" if backend else experiment.name


def _other_backend(experiment: Experiment, settings: RunSettings) -> str:
    """Return the backend on which an experiment ran; empty if it is the default."""
    if not experiment.backend:
        return ""
    own = "" if settings.backend == experiment.backend else settings.backend
    eyes = "" if settings.cameras is None else f"{settings.cameras} cameras"
    return " with ".join(filter(None, (own or (eyes and settings.backend), eyes)))


def _command(experiment: Experiment, settings: RunSettings) -> str:
    words = ["cb", "reproduce", experiment.name, "--seed", str(settings.seed)]
    if experiment.backend:
        words += ["--backend", settings.backend]
        words += ["--cameras", settings.cameras] if settings.cameras is not None else []
    if settings.trials is not None and (experiment.learns or experiment.keeps):
        words += ["--trials", str(settings.trials)]
    return " ".join([*words, "--quick"] if settings.quick else words)


def _quantity(quantity: Quantity) -> dict[str, object]:
    return {
        "name": quantity.name,
        "unit": quantity.claim.unit,
        "source": quantity.claim.report,
        "ours": None if math.isnan(quantity.ours) else quantity.ours,
        # JSON has no infinity.
        "interval": quantity.interval
        and [end if math.isfinite(end) else None for end in quantity.interval],
        "expected": quantity.expected.text if quantity.expected else None,
        "chance": quantity.chance,
        "verdict": quantity.verdict.value,
        "note": quantity.note,
    }


def _chance(quantity: Quantity) -> str:
    """Return the chance of a false verdict; empty if nothing is sampled or judged."""
    if quantity.verdict is Verdict.NOT_JUDGED or _is_computed(quantity):
        return ""
    return f"{100 * quantity.chance:.2g} %"


def _is_computed(quantity: Quantity) -> bool:
    ends = quantity.interval
    return ends is not None and ends[0] == ends[1] and quantity.chance == 0.0


def _measured(quantity: Quantity) -> str:
    if math.isnan(quantity.ours):
        return "none"
    text = f"{quantity.ours:.3g}"
    if quantity.interval is not None and not _is_computed(quantity):
        low, high = quantity.interval
        text += f" [{low:.3g}, {high:.3g}]"
    return f"{text} {quantity.claim.unit}".rstrip()


def _escaped(cell: str) -> str:
    # Bars end a cell of Markdown, and pairs of stars emphasise the text between them.
    return cell.replace("|", "\\|").replace("*", "\\*")
