"""Icons of catalogs: one layer per affordance, the most certain next to the object."""

from __future__ import annotations

import re
from xml.etree import ElementTree

from cbdsl.reporting.drawing.catalog_icon import Layer, catalog_icon

LAYERS = [Layer("touch", 10, 9), Layer("lift", 4, 0), Layer("inspect <blue>", 8, 2)]


def test_icon_has_a_layer_for_each_rewarded_action() -> None:
    svg = catalog_icon("ball", "red", LAYERS)
    texts = [
        each.text
        for each in ElementTree.fromstring(svg).iter()
        if each.text and each.tag[-4:] == "text"
    ]
    assert texts == ["inspect <blue>", "2 of 8", "touch", "9 of 10", "ball (red)"]


def test_layer_is_filled_by_its_share_of_rewards() -> None:
    svg = catalog_icon("ball", "red", [Layer("touch", 10, 5)])
    whole, filled, _ = (
        float(each) for each in re.findall(r'rx="5" width="([\d.]+)"', svg + ' rx="5" width="0"')
    )
    assert filled == whole / 2
