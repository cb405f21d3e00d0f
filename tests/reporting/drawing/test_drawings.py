"""Graphs of the shipped programs, in every notation."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Callable
from xml.etree import ElementTree

import pytest

from cbdsl.program.checked import CheckedProgram
from cbdsl.program.dry_run import Coverage
from cbdsl.reporting.drawing.dot import dot
from cbdsl.reporting.drawing.graph import Box, Graph, graph
from cbdsl.reporting.drawing.mermaid import mermaid
from cbdsl.reporting.drawing.svg import svg
from tests.program.test_dry_run import PROGRAMS, program_of

SVG = "{http://www.w3.org/2000/svg}"
NOTATIONS = (dot, mermaid, svg)


def within(program: CheckedProgram) -> list[CheckedProgram]:
    used = [action.program for action in program.actions if action.program is not None]
    return [program, *(inner for use in used for inner in within(use))]


def read(drawing: str) -> str:
    """A drawing's labels as a reader sees them."""
    codes = re.sub(r"#(\d+);", lambda match: chr(int(match[1])), drawing)
    return codes.replace("&gt;", ">").replace("&lt;", "<").replace("&amp;", "&")


@pytest.mark.parametrize("name", PROGRAMS)
@pytest.mark.parametrize("notation", NOTATIONS, ids=lambda notation: notation.__name__)
def test_everything_is_drawn(notation: Callable[[Graph], str], name: str) -> None:
    program = program_of(name)
    drawing = read(notation(graph(program)))
    for part in within(program):
        names = [part.name, *part.members, *part.policy, *(a.name for a in part.actions)]
        assert [name for name in names if name not in drawing] == []


@pytest.mark.parametrize("notation", NOTATIONS, ids=lambda notation: notation.__name__)
def test_the_end_is_drawn_where_states_have_no_action(notation: Callable[[Graph], str]) -> None:
    drawings = {n: notation(graph(program_of(n))) for n in ("reachtouch", "searchtrack")}
    assert "any other" in drawings["reachtouch"] and "any other" not in drawings["searchtrack"]


def hostile() -> Graph:
    """Names that no document can hold: they stay text."""
    box = Box('a"<b>&\\', ("`*_-",), True, ("*",), None)
    return Graph("x & y", ("<m>",), (box,), '"', Coverage(4, {"*": 4}, 0))


@pytest.mark.parametrize("name", PROGRAMS)
def test_svg_holds_its_boxes_without_overlap(name: str) -> None:
    root = ElementTree.fromstring(svg(graph(program_of(name))))
    width, height = float(root.attrib["width"]), float(root.attrib["height"])
    boxes: dict[str, list[tuple[float, ...]]] = {}
    for rectangle in root.iter(f"{SVG}rect"):
        place = tuple(float(rectangle.attrib[key]) for key in ("x", "y", "width", "height"))
        kind = "panel" if rectangle.attrib["class"] == "panel" else "box"
        boxes.setdefault(kind, []).append(place)
        assert place[0] + place[2] <= width and place[1] + place[3] <= height
    assert len(boxes["box"]) > len(boxes["panel"]) >= 1
    for same in boxes.values():
        for i, one in enumerate(same):
            assert not any(overlap(one, other) for other in same[i + 1 :])


def overlap(one: tuple[float, ...], other: tuple[float, ...]) -> bool:
    return all(
        one[axis] < other[axis] + other[axis + 2] and other[axis] < one[axis] + one[axis + 2]
        for axis in (0, 1)
    )


def test_svg_links_lead_to_the_panels_of_programs() -> None:
    root = ElementTree.fromstring(svg(graph(program_of("reachtouch"))))
    panels = {group.attrib["id"] for group in root.iter(f"{SVG}g")}
    links = {link.attrib["href"].removeprefix("#") for link in root.iter(f"{SVG}a")}
    assert links == {"searchtrack"} <= panels


def test_svg_escapes_names() -> None:
    texts = {element.text for element in ElementTree.fromstring(svg(hostile())).iter(f"{SVG}text")}
    assert {'a"<b>&\\', "`*_-", "<m>", 'x & y; below: "'} <= texts


def test_mermaid_labels_hold_nothing_that_has_a_meaning() -> None:
    labels = re.findall(r'"([^"]*)"', mermaid(hostile()))
    assert len(labels) == 4
    assert all(not re.search(r"[<>&*_`-]", label.replace("<br>", "")) for label in labels)
    assert read(mermaid(hostile())).count('a"<b>&\\') == 1


@pytest.mark.parametrize("name", PROGRAMS)
def test_mermaid_declares_every_node_and_ends_every_subgraph(name: str) -> None:
    text = mermaid(graph(program_of(name)))
    lines = [line.strip() for line in text.splitlines()]
    assert lines[0] == "flowchart LR"
    assert lines.count("end") == sum(line.startswith("subgraph") for line in lines)
    ends = re.findall(r"(\w+)(?= -\.->)|(?<=-\.-> )(\w+)", text)
    declared = set(re.findall(r"(\w+)(?=[\[{(])", text))
    assert {one or other for one, other in ends} <= declared


@pytest.mark.skipif(shutil.which("dot") is None, reason="needs Graphviz")
@pytest.mark.parametrize("drawn", [*PROGRAMS, "hostile"])
def test_graphviz_reads_dot(drawn: str) -> None:
    text = dot(hostile() if drawn == "hostile" else graph(program_of(drawn)))
    run = subprocess.run(["dot", "-Tsvg"], input=text, capture_output=True, text=True)
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout.count('class="node"') == len(re.findall(r"shape=", text))
