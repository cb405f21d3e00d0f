"""Charts: well-formed pictures of their curves and bars, equal for equal data."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cbdsl_reproduction.bar_chart import Bar, BarChart
from cbdsl_reproduction.chart import Chart, Line

SVG = "{http://www.w3.org/2000/svg}"
# Numbers in the range of measurements, without tiny ones.
NUMBERS = st.floats(-1e6, 1e6).map(lambda number: round(number, 6))


def chart(*lines: Line) -> Chart:
    return Chart("name", "a < b & $c", "time, s", "phi_1 $", lines)


def drawn(*lines: Line, kind: str = "curve") -> list[list[tuple[float, float]]]:
    """Return the corners of each curve or interval in the picture, px."""
    root = ET.fromstring(chart(*lines).svg())
    groups = [each for each in root.iter(f"{SVG}g") if each.get("id", "").startswith(kind)]
    return [
        [(float(x), float(y)) for path in group.iter(f"{SVG}path")
         for x, y in re.findall(r"[ML] ([-\d.e]+) ([-\d.e]+)", path.attrib["d"])]
        for group in groups
    ]  # fmt: skip


@settings(max_examples=10, deadline=None)
@given(st.lists(st.tuples(NUMBERS, NUMBERS), min_size=2, max_size=5, unique_by=lambda p: p[0]))
def test_every_point_lies_within_the_picture(points: list[tuple[float, float]]) -> None:
    x, y = zip(*points, strict=True)
    (corners,) = drawn(Line("all", x, y))
    assert corners
    assert all(0 <= across <= 461 and 0 <= down <= 224 for across, down in corners)


def test_larger_values_are_higher_and_later_ones_further_right() -> None:
    (corners,) = drawn(Line("rising", (0.0, 1.0, 2.0), (0.0, 1.0, 5.0)))
    assert len(corners) == 3 and corners == sorted(corners)
    assert [down for _, down in corners] == sorted((down for _, down in corners), reverse=True)


def test_curves_share_their_axes() -> None:
    low, high = drawn(Line("low", (0.0, 1.0), (0.0, 1.0)), Line("high", (0.0, 1.0), (0.0, 2.0)))
    assert low[0] == pytest.approx(high[0])
    assert low[1][0] == pytest.approx(high[1][0])
    assert low[1][1] - low[0][1] == pytest.approx((high[1][1] - high[0][1]) / 2, abs=0.2)


def test_interval_encloses_its_curve() -> None:
    line = Line("one", (0.0, 1.0), (1.0, 2.0), low=(0.5, 1.0), high=(1.5, 4.0))
    root = ET.fromstring(chart(line).svg())
    (band,) = (each for each in root.iter() if each.get("id") == "interval one")
    (curve,) = drawn(line)
    (shape,), (use,) = band.iter(f"{SVG}path"), band.iter(f"{SVG}use")
    corners = re.findall(r"[ML] [-\d.e]+ ([-\d.e]+)", shape.attrib["d"])
    downs = [float(use.attrib["y"]) + float(down) for down in corners]
    assert min(downs) < min(down for _, down in curve)
    assert max(downs) > max(down for _, down in curve)


def test_equal_charts_have_equal_texts_with_their_words() -> None:
    line = Line("a curve", (0.0, 1.0), (1.0, 2.0))
    first = chart(line).svg()
    assert first == chart(line).svg() and first.startswith("<svg")
    words = [each.text for each in ET.fromstring(first).iter(f"{SVG}text")]
    assert {"a < b & $c", "time, s", "phi_1 $", "a curve"} <= set(words)


def test_bars_are_as_long_as_their_parts_in_order() -> None:
    bars = (Bar("reach", 2.0, 1.0), Bar("touch", 4.0))
    text = BarChart("name", "title", bars, "rewarded", "others").svg()
    words = [each.text for each in ET.fromstring(text).iter(f"{SVG}text")]
    assert {"reach", "touch", "rewarded", "others"} <= set(words)
    assert {"2 + 1", "4 + 0"} <= {str(word).strip() for word in words}
