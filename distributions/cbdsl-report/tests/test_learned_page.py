"""Page of learned policies: complete, self-contained and reproducible."""

from __future__ import annotations

import base64
import json
import re
import zlib
from dataclasses import replace
from typing import Any
from xml.etree import ElementTree

import pytest

from cbdsl.reporting.drawing.policy_graph import policy_graph
from cbdsl.reporting.drawing.policy_transitions import decisions, policy_transitions
from cbdsl.reporting.drawing.svg import svg
from cbdsl_report.density_svg import density_svgs
from cbdsl_report.learned_files import Learned, read_learned
from cbdsl_report.learned_page import learned_page
from tests.reporting.test_page import Loads
from tests.reporting.trials import write_trial


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory) -> list[Learned]:
    folder = tmp_path_factory.mktemp("knowledge")
    return [read_learned(write_trial(folder, f"walked_{seed}", seed)) for seed in range(3)]


@pytest.fixture(scope="module")
def text(learned: list[Learned]) -> str:
    return learned_page(learned, 0.2)


def header(text: str) -> dict[str, Any]:
    (packed,) = re.findall(r'id="data">([^<]*)<', text)
    content = zlib.decompress(base64.b64decode(packed))
    size = int.from_bytes(content[:4], "little")
    told: dict[str, Any] = json.loads(content[4 : 4 + size])
    return told


def test_learned_page_loads_nothing(text: str) -> None:
    parser = Loads()
    parser.feed(text)
    assert all(each.startswith("data:") for each in parser.found)
    assert parser.policy.startswith("default-src 'none';")
    assert not re.search(r"connect-src|https?:", parser.policy)


def test_same_files_give_the_same_page(learned: list[Learned], text: str) -> None:
    assert learned_page(learned, 0.2) == text


def test_each_trial_has_all_its_states_and_the_same_diagram_as_alone(
    learned: list[Learned], text: str
) -> None:
    sections = text.split('<section class="trial"')[1:]
    assert len(sections) == len(learned)
    for each, section in zip(learned, sections, strict=True):
        rewarded = {episode.end for episode in each.experiences if episode.reward}
        graph = policy_transitions(each.policy, 0.2, False, each.programs, rewarded)
        assert svg(policy_graph(graph)) in section
        cells = re.findall(r'<span class="letter p-.*?</th>', section)
        states = ["".join(re.findall(r">(.)</span>", cell)) for cell in cells]
        assert states == [decision.state for decision in decisions(each.policy)]


def test_share_of_arcs_can_be_chosen(learned: list[Learned]) -> None:
    few, many = (learned_page(learned[:1], above).count('class="arc"') for above in (0.9, 0.0))
    assert few < many


def test_data_hold_every_episode(learned: list[Learned], text: str) -> None:
    told = header(text)
    assert [group["trials"] for group in told["groups"]] == [3]
    for each, trial in zip(learned, told["trials"], strict=True):
        assert [row["seed"] for row in trial["episodes"]] == [e.seed for e in each.experiences]
        assert [row["ticks"] for row in trial["episodes"]] == list(each.curve.ticks)


def test_names_cannot_be_markup(learned: list[Learned]) -> None:
    hostile = "</script><b>{{data}}"
    policy = learned[0].policy.model_copy(
        update={"predicates": (hostile, "x"), "policy": {"XX": hostile}, "program": hostile}
    )
    text = learned_page([replace(learned[0], policy=policy, notes=(hostile,))], 0.2)
    assert "<b>" not in text and "&lt;b&gt;{{data}}" in text
    assert len(re.findall(r"</script", text, re.IGNORECASE)) == 2


def test_densities_are_maps_or_curves_with_words(learned: list[Learned]) -> None:
    head, hand = learned[0].models
    (picture,) = density_svgs(head)
    assert picture.count("<circle") == 15 and "data:image/png" in picture
    curves = density_svgs(hand)
    assert len(curves) == 4
    for each in (picture, *curves):
        root = ElementTree.fromstring(each)
        width, height = float(root.attrib["width"]), float(root.attrib["height"])
        assert [child.tag.split("}")[1] for child in root][:2] == ["title", "desc"]
        for element in root.iter("{http://www.w3.org/2000/svg}text"):
            assert 0 <= float(element.attrib["x"]) <= width
            assert 0 <= float(element.attrib["y"]) <= height
    assert "Likeliest at 29°" in curves[0] and "Likeliest at 57°" in curves[1]
