"""Meta-catalogs as text."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.reporting.text.catalog_text import count_cells, feature_lines

if TYPE_CHECKING:
    from cbdsl.documents.meta_catalog import MetaCatalogDocument

_TITLES = ("pair", "stayed", "95 % interval", "value", "model")


def meta_catalog_text(catalog: MetaCatalogDocument) -> str:
    """Return a meta-catalog as text: its objects, its pairs and their constellations."""
    head = f"{catalog.name}: which things {catalog.robot} brings to which"
    if catalog.provenance is not None:
        origin = catalog.provenance
        head += f", after {origin.actions} actions on {origin.stage.name}"
    things = ", ".join(f"{name} ({thing.feature})" for name, thing in catalog.things.items())
    rows = [
        (f"{pair.upper} {pair.relation} {pair.lower}", *count_cells(pair))
        for pair in catalog.pairs.values()
    ]
    widths = [max(len(row[i]) for row in (_TITLES, *rows)) for i in range(len(_TITLES))]
    lines = [head, f"things: {things}", ""]
    lines.extend(
        "  ".join(f"{cell:{width}s}" for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in (_TITLES, *rows)
    )
    for name, pair in catalog.pairs.items():
        lines += feature_lines(name, pair)
    return "\n".join(lines) + "\n"
