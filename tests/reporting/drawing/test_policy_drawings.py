"""Drawings of policies, in every notation."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Callable
from html import unescape
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cbdsl.documents.policy import PolicyDocument
from cbdsl.reporting.drawing.dot import dot
from cbdsl.reporting.drawing.graph import Graph
from cbdsl.reporting.drawing.mermaid import mermaid
from cbdsl.reporting.drawing.pictogram import LETTERS, symbols
from cbdsl.reporting.drawing.policy_graph import percent, policy_graph, sentence, title
from cbdsl.reporting.drawing.policy_transitions import PolicyTransitions, policy_transitions
from cbdsl.reporting.drawing.svg import svg
from tests.reporting.drawing.policies import MEMBERS, POLICIES, learned

SVG = "{http://www.w3.org/2000/svg}"
TRANSITIONS = st.builds(
    policy_transitions, POLICIES, st.floats(0, 0.9), st.booleans(), st.just(frozenset(MEMBERS[:1]))
)


def read(drawing: str) -> str:
    """Return a drawing's labels as a reader sees them."""
    return unescape(re.sub(r"#(\d+);", lambda match: chr(int(match[1])), drawing))


@pytest.mark.parametrize("draw", [dot, mermaid, svg])
@given(policy=TRANSITIONS)
@settings(max_examples=25)
def test_every_state_action_and_share_is_drawn(
    draw: Callable[[Graph], str], policy: PolicyTransitions
) -> None:
    drawing = read(draw(policy_graph(policy)))
    if draw is dot:
        drawing = re.sub(r"</FONT></TD><TD[^>]*><FONT[^>]*>", " ", drawing)
    for decision in policy.decisions:
        wanted = decision.state if draw is svg else symbols(decision.state)
        assert wanted in drawing
        assert decision.action is None or decision.action in drawing
    for arc in policy.arcs:
        assert percent(arc.share) in drawing
    arrows = {dot: " -> ", mermaid: " -->|", svg: 'class="arc"'}[draw]
    began = sum(bool(each.started) for each in policy.decisions)
    besides = 0 if draw is mermaid else began
    assert drawing.count(arrows) == len(policy.arcs) + besides


@given(TRANSITIONS)
@settings(max_examples=50)
def test_svg_holds_its_states_apart_and_with_their_pictograms(policy: PolicyTransitions) -> None:
    root = ElementTree.fromstring(svg(policy_graph(policy)))
    width, height = float(root.attrib["width"]), float(root.attrib["height"])
    nodes = [each for each in root.iter(f"{SVG}rect") if each.attrib.get("class") == "node"]
    assert len(nodes) == len(policy.decisions)
    boxes = [tuple(float(each.attrib[key]) for key in ("x", "y", "width", "height"))
             for each in nodes]  # fmt: skip
    for place, (x, y, w, h) in enumerate(boxes):
        assert 0 <= w <= width and 0 <= h <= height
        assert not any(
            x < x2 + w2 and x2 < x + w and y < y2 + h2 and y2 < y + h
            for x2, y2, w2, h2 in boxes[place + 1 :]
        )
    papers = [each.attrib["fill"] for each in root.iter(f"{SVG}rect") if "fill" in each.attrib]
    for letter, look in LETTERS.items():
        drawn = sum(
            (2 if member in policy.programs else 1)
            for decision in policy.decisions
            for member, own in zip(policy.members, decision.state, strict=True)
            if own == letter
        )
        assert papers.count(look.paper) == drawn + (letter != "*")


def test_learned_policy_with_the_name_of_its_program_is_titled_as_learned() -> None:
    policy = learned([[("reach", "1X")]]).model_copy(update={"name": "walking"})
    written = policy.model_copy(update={"values": {}, "transitions": {}, "curve": None})
    assert title(policy_transitions(policy)) == "walking, a policy of walking"
    assert title(policy_transitions(written)) == "walking, the policy written in it"


def test_names_stay_text() -> None:
    hostile = 'a"<b>&\\'
    policy = PolicyDocument(
        cbdsl=1,
        kind="policy",
        name="walked",
        program="p",
        predicates=(hostile,),
        policy={"X": hostile},
    )
    graph = policy_graph(policy_transitions(policy))
    texts = {each.text for each in ElementTree.fromstring(svg(graph)).iter(f"{SVG}text")}
    assert hostile in texts
    assert hostile in read(mermaid(graph)) and hostile not in mermaid(graph)
    assert '<B>a"&lt;b&gt;&amp;\\</B>' in dot(graph)


@given(TRANSITIONS)
@settings(max_examples=25)
def test_sentence_of_a_state_names_its_arcs(policy: PolicyTransitions) -> None:
    for decision in policy.decisions:
        own = [arc for arc in policy.arcs if arc.source == decision.state]
        told = sentence(policy, decision)
        assert re.findall(r"(\d+ %) to (\S+)[;.]", told) == [
            (percent(arc.share), arc.target) for arc in own
        ]


@pytest.mark.skipif(shutil.which("dot") is None, reason="needs Graphviz")
@given(TRANSITIONS)
@settings(max_examples=5, deadline=None)
def test_graphviz_reads_dot(policy: PolicyTransitions) -> None:
    run = subprocess.run(
        ["dot", "-Tsvg"], input=dot(policy_graph(policy)), capture_output=True, text=True
    )
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout.count('class="edge"') == dot(policy_graph(policy)).count(" -> ")
