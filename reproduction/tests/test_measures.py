"""Measures of judges: their draws, their errors, and their counts of outcomes."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.api.documents import MetaCatalogDocument
from cbdsl.api.shipped import shipped_document
from cbdsl_reproduction.constellation_trials import ConstellationTrial
from cbdsl_reproduction.judges import constellations, five_skills, schemas, triangulation
from cbdsl_reproduction.judges.force import drawn_slide


def test_error_of_a_position_is_split_along_the_line_of_sight() -> None:
    truth, eyes = np.array([1.0, 0.0, 0.0]), np.zeros(3)
    errors = triangulation.errors(np.array([1.003, 0.004, 0.0]), truth, eyes)
    assert errors == pytest.approx({"error_mm": 5.0, "depth_mm": 3.0, "across_mm": 4.0})


@pytest.mark.parametrize("side", ["left", "right"])
def test_slide_is_10_cm_long_on_the_half_of_its_hand(side: str) -> None:
    values, by = drawn_slide(5, side)
    assert np.linalg.norm(by) == pytest.approx(0.1)
    assert (float(values["y"].split()[0]) > 0) == (side == "left")
    assert values["hand"] == f"{side}_hand"


def counts(**given: tuple[int, int]) -> dict[str, list[int]]:
    full = {"possible": 20, "alone": 20, "out_of_reach": 20, "touched_in_vain": 0}
    base = {name: [most, most] for name, most in full.items()} | {"false_alarms": [0, 40]}
    return base | {name: list(pair) for name, pair in given.items()}


@pytest.mark.parametrize(
    ("given", "holds"),
    [
        (counts(), True),
        (counts(possible=(18, 20)), False),
        (counts(alone=(17, 20)), False),
        (counts(out_of_reach=(18, 20)), False),
        (counts(false_alarms=(1, 40)), False),
        (counts(touched_in_vain=(0, 9)), True),
    ],
)
def test_schema_holds_if_each_share_reaches_its_aim(
    given: dict[str, list[int]], holds: bool
) -> None:
    assert schemas.holds(given) == holds


def test_fallen_pair_that_is_judged_to_stand_is_a_false_judgement() -> None:
    catalog = shipped_document(MetaCatalogDocument, "four_things")
    trial = ConstellationTrial("football_on_blue_box", 1, True, False, {}, {}, "")
    outcomes = constellations.outcomes(catalog, trial)
    assert outcomes["judged standing though fallen"] is True
    assert outcomes["judged standing"] is outcomes["pair by constellation"] is None
    # Without features a pair does not count as standing, which is right before and after.
    assert outcomes["beside, told before"] is outcomes["on or beside, told after"] is True
    stood = constellations.outcomes(catalog, trial._replace(stands=True))
    assert stood["on or beside, told after"] is stood["pair by constellation"] is False
    assert stood["judged standing though fallen"] is False


def test_skills_are_learned_bottom_up() -> None:
    names = list(five_skills.SKILLS)
    assert names.index("searchtrack") < names.index("reachtouch") < names.index("bimanualtouch")
