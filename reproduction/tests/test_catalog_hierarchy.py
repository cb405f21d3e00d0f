"""Hierarchies of catalogs: each composite stands above its parts."""

from __future__ import annotations

import re
from xml.etree import ElementTree

from cbdsl.reporting.drawing.catalog_icon import Layer
from cbdsl_reproduction.catalog_hierarchy import CatalogNode, catalog_hierarchy

NODES = {
    "box": CatalogNode("a <box>", [Layer("touch", 4, 4), Layer("lift", 4, 0)]),
    "ball": CatalogNode("a ball", [Layer("touch", 4, 3)]),
    "pair": CatalogNode("both", [Layer("seen", 2, 1)], ("box", "ball"), "place"),
    "tower": CatalogNode("three", [], ("pair", "ball"), "place"),
}


def heights() -> dict[str, float]:
    """Return the vertical position of each name, px from the top."""
    found: dict[str, float] = {}
    for group in ElementTree.fromstring(catalog_hierarchy(NODES)):
        moved = re.match(r"translate\(\S+ (\S+)\)", group.get("transform", ""))
        if moved is not None:
            texts = [each for each in group if each.tag.endswith("text")]
            found[str(texts[-1].text)] = float(moved[1]) + float(texts[-1].get("y", "0"))
    return found


def test_node_is_drawn_above_its_parts_and_objects_on_one_line() -> None:
    known = heights()
    assert known["three"] < known["both"] < known["a ball"] == known["a <box>"]


def test_line_leads_from_each_node_to_its_parts() -> None:
    drawn = catalog_hierarchy(NODES)
    assert drawn.count("<line") == 4
    assert drawn.count(">place<") == 2


def test_action_without_reward_has_no_layer() -> None:
    drawn = catalog_hierarchy(NODES)
    assert ">lift<" not in drawn
    assert drawn.count(">touch<") == 2
    assert ">3 of 4<" in drawn
