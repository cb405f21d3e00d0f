"""Hulls of fixtures cover them in all places that a stage may draw."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import linprog

from cbdsl.checking.stage.fixture_hulls import fixture_hull
from cbdsl.documents.robot import HullSection
from cbdsl.documents.stage import StageDocument

PLACE = ["40 cm", ["-10 cm", "10 cm"], "0 cm"]


def stage(form: dict[str, Any]) -> StageDocument:
    return StageDocument.model_validate(
        {"cbdsl": 1, "kind": "stage", "name": "one", "robot": "dexter", "contexts": {"still": {}},
         "fixtures": {"shelf": {"form": form, "position": PLACE}}}
    )  # fmt: skip


def is_inside(points: np.ndarray, point: np.ndarray) -> bool:
    """Return whether a point is a convex combination of others."""
    rows = np.vstack([points.T, np.ones(len(points))])
    return bool(linprog(np.zeros(len(points)), A_eq=rows, b_eq=[*point, 1.0]).status == 0)


@pytest.mark.parametrize("shape", ["cylinder", "tube"])
def test_hull_of_a_cylinder_contains_its_rim_in_all_places(shape: str) -> None:
    form = {"shape": shape, "radius": "8 cm", "height": "20 cm"}
    if shape == "tube":
        form["wall"] = "1 cm"
    hull = fixture_hull("shelf", stage(form))
    assert isinstance(hull, HullSection)
    for turn in np.linspace(0.0, 6.0, 13):
        for y, z in ((-0.1, -0.1), (0.0, 0.1), (0.1, 0.1)):
            rim = np.array([0.4 + 0.08 * np.cos(turn), y + 0.08 * np.sin(turn), z])
            assert is_inside(np.array(hull.points), rim)


def test_hull_of_a_box_ends_at_its_sides() -> None:
    form = {"shape": "box", "size": ["20 cm", "40 cm", "4 cm"]}
    hull = fixture_hull("shelf", stage(form))
    assert isinstance(hull, HullSection) and hull.radius == 0.0
    corners = np.array(hull.points)
    np.testing.assert_allclose(corners.min(axis=0), [0.3, -0.3, -0.02])
    np.testing.assert_allclose(corners.max(axis=0), [0.5, 0.3, 0.02])


def test_hull_of_a_ball_has_its_largest_radius() -> None:
    hull = fixture_hull("shelf", stage({"shape": "ball", "radius": ["3 cm", "5 cm"]}))
    assert isinstance(hull, HullSection) and hull.radius == pytest.approx(0.05)
    assert set(hull.points) == {(0.4, -0.1, 0.0), (0.4, 0.1, 0.0)}


def test_fixture_that_a_stage_lacks_is_named_with_the_known_ones() -> None:
    says = fixture_hull("bench", stage({"shape": "ball", "radius": "5 cm"}))
    assert says == "'bench' is no fixture of stage 'one' (known: shelf)"
