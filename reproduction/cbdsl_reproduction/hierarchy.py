"""Hierarchy of catalogs as a picture of an experiment (Figures 7.10 and 7.17)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from cbdsl_reproduction.catalog_hierarchy import CatalogNode, catalog_hierarchy


@dataclass(frozen=True)
class Hierarchy:
    """Hierarchy of catalogs, each above the catalogs that it joins.

    Attributes:
        name: Name of the file, without suffix.
        title: Title of the picture.
        nodes: Nodes by name; see ``catalog_hierarchy``.
    """

    name: str
    title: str
    nodes: Mapping[str, CatalogNode]

    def svg(self) -> str:
        """Return the picture as the text of an SVG file."""
        return catalog_hierarchy(self.title, self.nodes)

    def data(self) -> dict[str, object]:
        """Return the numbers of rewards and attempts of each affordance, for scripts."""
        return {
            name: {
                "below": list(node.below),
                "affords": {each.name: [each.rewarded, each.tried] for each in node.layers},
            }
            for name, node in self.nodes.items()
        }
