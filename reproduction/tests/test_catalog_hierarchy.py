"""Hierarchies of catalogs: each composite stands above its parts."""

from __future__ import annotations

from xml.etree import ElementTree

from cbdsl.reporting.drawing.catalog_icon import Layer
from cbdsl_reproduction.catalog_hierarchy import CatalogNode, catalog_hierarchy

NODES = {
    "box": CatalogNode("a <box>", [Layer("touch", 4, 4), Layer("lift", 4, 0)]),
    "ball": CatalogNode("a ball", [Layer("touch", 4, 3)]),
    "pair": CatalogNode("both", [Layer("seen", 2, 1)], ("box", "ball"), "place"),
    "tower": CatalogNode("three", [], ("pair", "ball"), "place"),
}
DRAWN = catalog_hierarchy("Joined", NODES)


def heights() -> dict[str, float]:
    """Return the vertical position of each text, px from the top."""
    texts = [each for each in ElementTree.fromstring(DRAWN).iter() if each.tag.endswith("text")]
    return {"".join(each.itertext()): float(each.get("y", "0")) for each in texts}


def test_node_is_drawn_above_its_parts_and_objects_on_one_line() -> None:
    known = heights()
    assert known["three"] < known["both"] < known["a ball"] == known["a <box>"]


def test_line_leads_from_each_node_to_its_parts() -> None:
    assert DRAWN.count('id="joins"') == 4
    assert DRAWN.count(">place<") == 2


def test_action_without_reward_has_no_layer() -> None:
    assert ">lift<" not in DRAWN
    assert DRAWN.count(">touch<") == 2
    assert ">3 of 4<" in DRAWN
