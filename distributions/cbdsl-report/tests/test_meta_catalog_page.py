"""The page of a meta-catalog: its graph, and the stacks that follow."""

from __future__ import annotations

import base64
import json
import re
import zlib
from typing import Any

import pytest

from cbdsl.documents.meta_catalog import MetaCatalogDocument, PairSection
from cbdsl.yaml_text.library import Library
from cbdsl_report.meta_catalog_page import meta_catalog_page
from tests.conftest import ROOT


@pytest.fixture(scope="module")
def shipped() -> MetaCatalogDocument:
    library = Library(ROOT)
    file = library.locate(MetaCatalogDocument, "four_things")
    return library.read(file, MetaCatalogDocument).document


@pytest.fixture(scope="module")
def page(shipped: MetaCatalogDocument) -> str:
    return meta_catalog_page(shipped)


def plans_of(page: str) -> list[dict[str, Any]]:
    """Return the data of the page's script."""
    text = re.search(r'id="data">([^<]*)<', page)
    assert text is not None
    plain = zlib.decompress(base64.b64decode(text[1]))
    size = int.from_bytes(plain[:4], "little")
    plans: list[dict[str, Any]] = json.loads(plain[4 : 4 + size])["plans"]
    return plans


def test_stacks_of_each_height_are_listed_by_probability(page: str) -> None:
    plans = plans_of(page)
    assert {len(plan["order"]) for plan in plans} == {2, 3}, "no four things stood on each other"
    of_three = [plan for plan in plans if len(plan["order"]) == 3]
    assert [plan["order"][-1] for plan in of_three] == ["football", "basketball"]
    assert of_three[0]["probability"] >= of_three[1]["probability"]
    assert of_three[1]["command"] == (
        "cb run stack_three --with goal=blue --with middle=hue_9 --with feature=red"
    )


def test_every_object_of_a_stack_is_in_the_graph(page: str) -> None:
    drawn = set(re.findall(r'data-key="([^"]*)"', page))
    for plan in plans_of(page):
        known = [key for key in plan["boxes"] if len(plan["order"]) == 3 or "stack " not in key]
        assert set(known) <= drawn, plan


def test_page_reports_every_pair_and_its_origin(page: str, shipped: MetaCatalogDocument) -> None:
    for pair in shipped.pairs.values():
        assert f"{pair.upper} on {pair.lower}" in page
        assert f"{pair.rewarded} of {pair.tried}" in page
    assert "cb explore" in page


def test_without_pairs_there_is_nothing_to_plan() -> None:
    things = {"cup": {"feature": "red"}}
    given = {"cbdsl": 1, "kind": "meta_catalog", "name": "a", "robot": "dexter", "things": things}
    page = meta_catalog_page(MetaCatalogDocument.model_validate(given))
    assert "0 of 0 pairs ever stayed" in page and plans_of(page) == []


def test_thing_in_another_one_is_no_part_of_a_stack() -> None:
    """Pairs may have been brought together in two ways, on and in."""
    things = {"tray": {"feature": "blue"}, "box": {"feature": "red"}, "ball": {"feature": "green"}}
    known = {"program": "stand", "tried": 3, "rewarded": 3}
    pairs = {
        "box_on_tray": {"upper": "box", "lower": "tray", **known},
        "ball_on_box": {"upper": "ball", "lower": "box", **known},
        "box_in_tray": {"upper": "box", "lower": "tray", "relation": "in", **known, "rewarded": 0},
    }
    given = {"cbdsl": 1, "kind": "meta_catalog", "name": "a", "robot": "dexter", "things": things}
    catalog = MetaCatalogDocument.model_validate(given)
    sections = {name: PairSection.model_validate(pair) for name, pair in pairs.items()}
    page = meta_catalog_page(catalog.model_copy(update={"pairs": sections}))
    assert 'data-key="stack tray box ball"' in page and "pair box_in_tray" not in page
