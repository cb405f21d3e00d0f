"""Graphs of the shipped programs, in every format."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Callable
from xml.etree import ElementTree

import pytest

from cbdsl.program.checked import CheckedProgram
from cbdsl.reporting.automaton_text import automata
from cbdsl.reporting.drawing.automaton_graph import automaton_graph, graph_of_steps
from cbdsl.reporting.drawing.dot import dot
from cbdsl.reporting.drawing.graph import Edge, Graph, Outline, TextLine, Vertex
from cbdsl.reporting.drawing.mermaid import mermaid
from cbdsl.reporting.drawing.svg import svg
from tests.program.test_dry_run import PROGRAMS, program_of

SVG = "{http://www.w3.org/2000/svg}"
NOTATIONS = (dot, mermaid, svg)


def within(program: CheckedProgram) -> list[CheckedProgram]:
    used = [action.program for action in program.actions if action.program is not None]
    return [program, *(inner for use in used for inner in within(use))]


def program_graph(program: CheckedProgram) -> Graph:
    return automaton_graph(program.name, automata(program))


def read(drawing: str) -> str:
    """Return a drawing's labels as a reader sees them."""
    codes = re.sub(r"#(\d+);", lambda match: chr(int(match[1])), drawing)
    codes = re.sub(r"</FONT></TD><TD[^>]*><FONT[^>]*>", " ", codes)
    return codes.replace("&gt;", ">").replace("&lt;", "<").replace("&amp;", "&")


@pytest.mark.parametrize("name", PROGRAMS)
@pytest.mark.parametrize("notation", NOTATIONS, ids=lambda notation: notation.__name__)
def test_graph_of_a_program_contains_its_steps_and_ends(
    notation: Callable[[Graph], str], name: str
) -> None:
    program = program_of(name)
    drawing = read(notation(program_graph(program)))
    for data in automata(program).values():
        exits = [each for step in data["steps"] for each in step["exits"]]
        names = [step["step"] for step in data["steps"]]
        names += [each["to"].split()[0] for each in exits if each["to"] not in names]
        assert [name for name in names if name not in drawing] == []


@pytest.mark.parametrize("name", PROGRAMS)
def test_graph_of_a_program_has_one_edge_for_the_exits_between_two_steps(name: str) -> None:
    for program, data in automata(program_of(name)).items():
        edges = graph_of_steps(program, data, {}).edges
        ways = {(edge.source, edge.target) for edge in edges}
        assert len(ways) == len(edges)
        written = {
            (step["step"], "fail" if each["to"].startswith("fail ") else each["to"])
            for step in data["steps"]
            for each in step["exits"]
        }
        assert ways == {way for way in written if way[0] != way[1]}


def test_graph_of_a_program_tells_why_it_fails() -> None:
    edges = automaton_graph("survey", automata(program_of("survey"))).edges
    label = next(edge.label for edge in edges if (edge.source, edge.target) == ("look", "fail"))
    assert label.splitlines()[0] == "wide: wider than the hand"
    assert label.splitlines()[-1] == "…"


def hostile() -> Graph:
    """Return a graph with names that no document can hold; they stay text."""
    label = (TextLine('a"<b>&\\'), TextLine("`*_-"))
    nodes = (
        Vertex("a", Outline.SELECTOR, (TextLine("<m>"),)),
        Vertex("b", Outline.ACTION, label),
    )
    edges = (Edge("a", "b", '"&'), Edge("b", "a"))
    return Graph("x", 'x & y; below: "', nodes, edges, ("<m>",))


@pytest.mark.parametrize("name", PROGRAMS)
def test_svg_has_its_labels_beside_each_other_and_within_the_picture(name: str) -> None:
    root = ElementTree.fromstring(svg(program_graph(program_of(name))))
    width = float(root.attrib["width"])
    for panel in (each for each in root.iter(f"{SVG}g") if "id" in each.attrib):
        left = float(re.findall(r"[\d.]+", panel.find(f"{SVG}g").attrib["transform"])[0])
        rectangles = [
            (each.attrib.get("class", ""), *(float(each.attrib[k]) for k in ("x", "width")),
             *(float(each.attrib[k]) for k in ("y", "height")))
            for each in panel.iter(f"{SVG}rect")
        ]  # fmt: skip
        labels = [each for each in rectangles if each[0] == "ground"]
        others = [each for each in rectangles if each[0].endswith("-node")]
        for place, (_, x, wide, y, tall) in enumerate(labels):
            assert left + x >= 0 and left + x + wide <= width
            for _, x2, wide2, y2, tall2 in (*labels[:place], *others):
                beside = x + wide <= x2 or x2 + wide2 <= x
                assert beside or y + tall <= y2 + 0.2 or y2 + tall2 <= y + 0.2


@pytest.mark.parametrize("name", PROGRAMS)
def test_svg_holds_its_nodes_without_overlap(name: str) -> None:
    root = ElementTree.fromstring(svg(program_graph(program_of(name))))
    width, height = float(root.attrib["width"]), float(root.attrib["height"])
    drawn = [each for each in root.iter(f"{SVG}g") if "id" in each.attrib]
    panels = {each.attrib["id"]: each for each in drawn}
    assert len(panels) == len(drawn)
    assert panels.keys() == automata(program_of(name)).keys()
    linked = {each.attrib["href"].removeprefix("#") for each in root.iter(f"{SVG}a")}
    assert linked == panels.keys() - {name}
    bottom = 0.0
    for panel in panels.values():
        offset = re.findall(r"[\d.]+", panel.find(f"{SVG}g").attrib["transform"])
        left, top = map(float, offset)
        assert top > bottom
        boxes = [
            tuple(float(rectangle.attrib[key]) for key in ("x", "y", "width", "height"))
            for rectangle in panel.iter(f"{SVG}rect")
            if rectangle.attrib.get("class", "").endswith("-node")
        ]
        assert boxes
        for place, one in enumerate(boxes):
            assert left + one[0] + one[2] <= width and top + one[1] + one[3] <= height
            assert not any(overlap(one, other) for other in boxes[place + 1 :])
        bottom = max(top + one[1] + one[3] for one in boxes)


def overlap(one: tuple[float, ...], other: tuple[float, ...]) -> bool:
    return all(
        one[axis] < other[axis] + other[axis + 2] and other[axis] < one[axis] + one[axis + 2]
        for axis in (0, 1)
    )


def test_svg_links_lead_to_the_panels_of_programs() -> None:
    root = ElementTree.fromstring(svg(program_graph(program_of("reachtouch"))))
    panels = {group.attrib.get("id") for group in root.iter(f"{SVG}g")}
    links = {link.attrib["href"].removeprefix("#") for link in root.iter(f"{SVG}a")}
    assert links <= panels


def test_svg_escapes_names() -> None:
    texts = {element.text for element in ElementTree.fromstring(svg(hostile())).iter(f"{SVG}text")}
    assert {'a"<b>&\\', "`*_-", "<m>", 'x & y; below: "'} <= texts


def test_mermaid_labels_hold_nothing_that_has_a_meaning() -> None:
    labels = re.findall(r'"([^"]*)"', mermaid(hostile()))
    assert len(labels) == 4  # title, two nodes, an edge
    assert all(not re.search(r"[<>&*_`-]", label.replace("<br>", "")) for label in labels)
    assert read(mermaid(hostile())).count('a"<b>&\\') == 1


@pytest.mark.parametrize("name", PROGRAMS)
def test_mermaid_declares_every_node_and_ends_every_subgraph(name: str) -> None:
    text = mermaid(program_graph(program_of(name)))
    lines = [line.strip() for line in text.splitlines()]
    assert lines[0] == "flowchart TD"
    assert lines.count("end") == sum(line.startswith("subgraph") for line in lines)
    ends = re.findall(r"(\w+)(?= -\.?->)|(?<=-> )(\w+)", text)
    declared = set(re.findall(r"(\w+)(?=[\[{(])", text))
    assert {one or other for one, other in ends} <= declared


@pytest.mark.skipif(shutil.which("dot") is None, reason="needs Graphviz")
@pytest.mark.parametrize("drawn", [*PROGRAMS, "hostile"])
def test_graphviz_reads_dot(drawn: str) -> None:
    text = dot(hostile() if drawn == "hostile" else program_graph(program_of(drawn)))
    run = subprocess.run(["dot", "-Tsvg"], input=text, capture_output=True, text=True)
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout.count('class="node"') == len(re.findall(r"shape=", text))
