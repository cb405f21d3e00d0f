"""Transition diagrams are well-formed pictures of their states and arcs."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from hypothesis import given
from hypothesis import strategies as st

from cbdsl.reproduction.arcs import Arc
from cbdsl.reproduction.diagram import Diagram

SVG = "{http://www.w3.org/2000/svg}"
STATES = st.text("X01-", min_size=2, max_size=2)
ARCS = st.builds(Arc, STATES, st.sampled_from(["a", "b ◁ a"]), STATES)


@given(st.dictionaries(ARCS, st.floats(0.2, 1.0), min_size=1, max_size=8))
def test_every_state_and_every_arc_is_shown_within_the_picture(arcs: dict[Arc, float]) -> None:
    root = ET.fromstring(Diagram("name", "a < b", "XX", arcs).svg())
    _, _, width, height = (float(each) for each in root.attrib["viewBox"].split())
    circles = [(float(c.attrib["cx"]), float(c.attrib["cy"])) for c in root.iter(f"{SVG}circle")]
    states = {"XX", *(arc.state for arc in arcs), *(arc.next_state for arc in arcs)}
    assert len(circles) == len(set(circles)) == len(states)
    assert all(0 < x < width and 0 < y < height for x, y in circles)
    texts = [each.text or "" for each in root.iter(f"{SVG}text")]
    for arc, share in arcs.items():
        assert f"{arc.action} {100 * share:.0f} %" in texts
    curves = [each for each in root.iter(f"{SVG}path") if "marker-end" in each.attrib]
    assert len(curves) == len({(arc.state, arc.next_state) for arc in arcs})


def test_states_stand_in_columns_by_how_soon_they_are_reached() -> None:
    arcs = {Arc("XX", "a", "X0"): 1.0, Arc("X0", "a", "X1"): 1.0, Arc("11", "a", "X0"): 1.0}
    root = ET.fromstring(Diagram("name", "title", "XX", arcs).svg())
    across = {
        each.text: float(each.attrib["x"])
        for each in root.iter(f"{SVG}text")
        if each.text in ("XX", "X0", "X1", "11")
    }
    assert sorted(across, key=lambda state: across[str(state)]) == ["XX", "X0", "X1", "11"]
