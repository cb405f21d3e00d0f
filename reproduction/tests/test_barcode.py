"""The nine barcodes: 10 cm wide, and finer from class to class."""

from __future__ import annotations

import pytest

from cbdsl.documents.stage import StageDocument
from cbdsl_reproduction.chapter_3.barcode import SIZE, Barcode, barcodes


def test_every_barcode_fills_its_width_and_ends_with_a_bar() -> None:
    for of_class in barcodes().values():
        assert len({barcode.stripes for barcode in of_class}) == 3
        for barcode in of_class:
            assert sum(barcode.stripes) == pytest.approx(SIZE)
            assert len(barcode.stripes) % 2 == 1


@pytest.mark.parametrize(
    ("frequency", "least", "most"),
    [("low", 0.030, 0.045), ("medium", 0.005, 0.006), ("high", 0.0017, 0.0023)],
)
def test_smallest_periods_are_about_those_of_the_source(
    frequency: str, least: float, most: float
) -> None:
    assert all(least <= barcode.period <= most for barcode in barcodes()[frequency])


def test_random_ones_are_the_same_every_time() -> None:
    assert barcodes() == barcodes()


def test_period_is_a_bar_and_the_gap_beside_it() -> None:
    assert Barcode("", (0.01, 0.02, 0.015, 0.005, 0.04)).period == pytest.approx(0.02)


def test_barcode_takes_the_place_of_the_pattern_on_a_thing() -> None:
    form = {"shape": "box", "size": [0.2] * 3, "pattern": {"face": "+y", "height": 0.05}}
    form["pattern"]["stripes"] = [0.1]
    stage = StageDocument.model_validate(
        {
            "cbdsl": 1,
            "kind": "stage",
            "name": "made",
            "robot": "dexter",
            "things": {
                "box": {"form": form, "mass": 0.3},
                "ball": {"form": {"shape": "ball", "radius": 0.1}, "mass": 0.3},
            },
            "contexts": {"only": {}},
        }
    )
    barcode = barcodes()["high"][1]
    printed = barcode.printed_on(stage, "box")
    again = StageDocument.model_validate(printed.model_dump())
    assert again == printed
    pattern = printed.things["box"].form.pattern
    assert (pattern.face, pattern.height, pattern.stripes) == ("+y", SIZE, barcode.stripes)
    with pytest.raises(ValueError, match="no box with a pattern"):
        barcode.printed_on(stage, "ball")
