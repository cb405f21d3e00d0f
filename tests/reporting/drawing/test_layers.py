"""Layouts: separated nodes in rows, and arcs from rim to rim around nodes in between."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cbdsl.reporting.drawing.layers import Layout, Size, Spacing, lay_out

SPACING = Spacing(across=10, down=40, lane=12)
NODES = [f"n{number}" for number in range(9)]
ARCS = st.lists(
    st.tuples(st.sampled_from(NODES), st.sampled_from(NODES)).filter(lambda arc: arc[0] != arc[1]),
    unique=True,
    max_size=20,
)
SIZES = st.fixed_dictionaries(
    {node: st.builds(Size, st.integers(20, 90), st.integers(20, 60)) for node in NODES}
)


def laid_out(sizes: dict[str, Size], arcs: list[tuple[str, str]]) -> Layout:
    return lay_out(sizes, arcs, NODES[:1], SPACING)


@given(SIZES, ARCS)
@settings(max_examples=60)
def test_nodes_are_apart_and_within(sizes: dict[str, Size], arcs: list[tuple[str, str]]) -> None:
    layout = laid_out(sizes, arcs)
    for place, node in enumerate(NODES):
        (x, y), size = layout.centers[node], sizes[node]
        assert x - size.width / 2 >= -1e-6 and x + size.width / 2 <= layout.size.width + 1e-6
        assert y - size.height / 2 >= -1e-6 and y + size.height / 2 <= layout.size.height + 1e-6
        for other in NODES[place + 1 :]:
            (x2, y2), size2 = layout.centers[other], sizes[other]
            across = abs(x - x2) - (size.width + size2.width) / 2
            down = abs(y - y2) - (size.height + size2.height) / 2
            assert across >= SPACING.across - 1e-6 or down >= SPACING.down - 1e-6


@given(SIZES, ARCS)
@settings(max_examples=60)
def test_routes_lead_from_rim_to_rim(sizes: dict[str, Size], arcs: list[tuple[str, str]]) -> None:
    layout = laid_out(sizes, arcs)
    assert set(layout.routes) == set(arcs)
    for arc, route in layout.routes.items():
        for node, (x, y) in zip(arc, (route[0], route[-1]), strict=True):
            (middle, level), size = layout.centers[node], sizes[node]
            assert abs(y - level) == pytest.approx(size.height / 2)
            assert abs(x - middle) < size.width / 2
    ends = [point for route in layout.routes.values() for point in (route[0], route[-1])]
    assert len(set(ends)) == len(ends)


@given(SIZES, ARCS)
@settings(max_examples=60)
def test_routes_pass_rows_between_their_nodes(
    sizes: dict[str, Size], arcs: list[tuple[str, str]]
) -> None:
    layout = laid_out(sizes, arcs)
    for route in layout.routes.values():
        for (x1, y1), (x2, y2) in pairwise(route[1:-1]):
            for node in NODES if x1 == x2 else ():
                (x, y), size = layout.centers[node], sizes[node]
                if min(y1, y2) <= y <= max(y1, y2):
                    assert abs(x - x1) >= size.width / 2


def test_chain_is_straight_and_follows_its_arcs_downwards() -> None:
    sizes = dict.fromkeys(NODES, Size(40, 20))
    layout = laid_out(sizes, list(pairwise(NODES)))
    places = [layout.centers[node] for node in NODES]
    assert len({x for x, _ in places}) == 1
    assert [y for _, y in places] == [10 + 60 * row for row in range(len(NODES))]


def test_tree_has_no_crossings() -> None:
    arcs = [("n0", "n1"), ("n0", "n2"), ("n1", "n5"), ("n2", "n3"), ("n1", "n6"), ("n2", "n4")]
    layout = laid_out(dict.fromkeys(NODES, Size(40, 20)), arcs)
    order = sorted(("n3", "n4", "n5", "n6"), key=lambda node: layout.centers[node][0])
    one_first = layout.centers["n1"] < layout.centers["n2"]
    assert set(order[:2]) == ({"n5", "n6"} if one_first else {"n3", "n4"})
