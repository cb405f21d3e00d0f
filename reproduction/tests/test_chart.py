"""Charts: well-formed pictures of their curves."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl_reproduction.chart import Chart, Line

SVG = "{http://www.w3.org/2000/svg}"
# Numbers in the range of measurements, without tiny ones.
NUMBERS = st.floats(-1e6, 1e6).map(lambda number: round(number, 6))


def drawn(*lines: Line) -> list[list[tuple[float, float]]]:
    """Return the corners of each curve in the picture, px."""
    root = ET.fromstring(Chart("name", "a < b", "time, s", "phi", lines).svg())
    return [
        [
            (float(x), float(y))
            for x, y in (pair.split(",") for pair in each.attrib["points"].split())
        ]
        for each in root.iter(f"{SVG}polyline")
    ]


@given(st.lists(st.tuples(NUMBERS, NUMBERS), min_size=1, max_size=20))
def test_every_point_lies_within_the_picture(points: list[tuple[float, float]]) -> None:
    x, y = zip(*points, strict=True)
    (corners,) = drawn(Line("all", x, y))
    assert len(corners) == len(points)
    assert all(69 <= across <= 411 and 33 <= down <= 255 for across, down in corners)


def test_larger_values_are_higher_and_later_ones_further_right() -> None:
    (corners,) = drawn(Line("rising", (0.0, 1.0, 2.0), (0.0, 1.0, 5.0)))
    assert corners == sorted(corners)
    assert [down for _, down in corners] == sorted((down for _, down in corners), reverse=True)


def test_curves_share_their_axes() -> None:
    low, high = drawn(Line("low", (0.0, 1.0), (0.0, 1.0)), Line("high", (0.0, 1.0), (0.0, 2.0)))
    assert low[0] == high[0]
    assert low[1][0] == high[1][0]
    assert low[1][1] - low[0][1] == pytest.approx((high[1][1] - high[0][1]) / 2, abs=0.2)


def test_an_interval_is_drawn_around_its_curve() -> None:
    line = Line("one", (0.0, 1.0), (1.0, 2.0), low=(0.5, 1.0), high=(1.5, 4.0))
    root = ET.fromstring(Chart("name", "title", "x", "y", (line,)).svg())
    (band,) = root.iter(f"{SVG}polygon")
    downs = [float(pair.split(",")[1]) for pair in band.attrib["points"].split()]
    (corners,) = drawn(line)
    for (_, middle), top, bottom in zip(corners, downs[:2], reversed(downs[2:]), strict=True):
        assert 33 <= top < middle < bottom <= 255
