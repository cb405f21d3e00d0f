"""Catalogs as text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.documents.catalog import AffordanceSection, CatalogDocument


def catalog_text(catalog: CatalogDocument) -> str:
    """Return a catalog as text: counts and intervals, then the features with reward."""
    head = f"{catalog.name}: what '{catalog.feature}' affords {catalog.robot}"
    if catalog.provenance is not None:
        origin = catalog.provenance
        head += f", after {origin.actions} actions on {origin.stage.name}"
    titles = ("action", "rewarded", "95 % interval", "value", "model")
    rows = [(name, *count_cells(each)) for name, each in catalog.affordances.items()]
    lines = [head, "", *aligned([titles, *rows])]
    for name, each in catalog.affordances.items():
        lines += feature_lines(name, each)
    return "\n".join(lines) + "\n"


def aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return the lines of a table, with all columns aligned left."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]


def count_cells(affordance: AffordanceSection) -> tuple[str, str, str, str]:
    """Return counts, interval, value and certainty of an affordance as text."""
    counts = f"{affordance.rewarded} of {affordance.tried}"
    interval = "-"
    if affordance.interval is not None:
        low, high = affordance.interval
        interval = f"{low:.2f} to {high:.2f}"
    return counts, interval, f"{affordance.value:+.3f}", _habituation(affordance)


def _habituation(affordance: AffordanceSection) -> str:
    if affordance.failed:
        return f"left out: {affordance.failed}"
    own = affordance.habituation
    if own is None:
        return "none"
    return f"{'habituated' if own.habituated else 'changing'}, by {own.change:.3f}"


def feature_lines(name: str, affordance: AffordanceSection) -> list[str]:
    """Mean and deviation of each component with reward."""
    model = affordance.with_reward
    if model is None:
        return []
    lines, place = ["", f"{name} with reward, {model.count} samples: mean and deviation"], 0
    for key, feature in affordance.features.items():
        own = range(place, place + feature.components)
        place += feature.components
        mean = ", ".join(f"{model.mean[i]:.3g}" for i in own)
        spread = ", ".join(f"{max(model.covariance[i][i], 0.0) ** 0.5:.2g}" for i in own)
        lines.append(f"  {key} ({feature.signal}, {feature.unit}): {mean} ± {spread}")
    return lines
