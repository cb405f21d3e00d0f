"""Boxes that are fitted to silhouettes, as exact hexagons and as pixels."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl_reproduction.worlds.box_fit import Floats, fit_box, hexagons
from cbdsl_reproduction.worlds.camera_pair import looking_at
from cbdsl_reproduction.worlds.edge_sensor import image_jacobian

CENTRE = np.array([0.02, -0.01, 0.02])
PAIR = looking_at((0.0, 0.0, 0.0))
VIEWS = [(np.reshape(each.axes, (3, 3)), np.array(each.position)) for each in PAIR.places.values()]
JACOBIANS = np.array([image_jacobian(axes, CENTRE - place) for axes, place in VIEWS])

heading = st.floats(0.0, math.pi / 2)
edge = st.floats(0.03, 0.05)


def apart(one: float, other: float) -> float:
    """Return the distance of two headings modulo a quarter turn, deg."""
    return math.degrees(abs((one - other + math.pi / 4) % (math.pi / 2) - math.pi / 4))


def photographed(turn: float, edges: Floats) -> Floats:
    """Return area and moments of the pixels of a box in both cameras, shape (2, 4)."""
    c, s = math.cos(turn), math.sin(turn)
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2
    corners = CENTRE + signs * edges @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    rows = []
    for axes, place in VIEWS:
        forward, left, up = ((corners - place) @ axes).T
        points = np.stack([-left / forward, -up / forward], axis=-1) * PAIR.focal_length
        middle = np.array([PAIR.width, PAIR.height]) / 2
        mask = np.zeros((PAIR.height, PAIR.width), np.uint8)
        outline = cv2.convexHull((points + middle).astype(np.float32))
        fixed = np.round((outline - 0.5) * 2**8).astype(np.int32)
        cv2.fillConvexPoly(mask, fixed, 1, lineType=cv2.LINE_8, shift=8)
        found = cv2.moments(mask, binaryImage=True)
        spread = np.array([found["mu20"], found["mu11"], found["mu02"]]) / found["m00"]
        rows.append([found["m00"], *spread])
    return np.array(rows) / PAIR.focal_length**2


@given(heading, edge, edge, edge)
def test_fit_of_hexagons_returns_the_heading_of_the_box(
    turn: float, first: float, second: float, height: float
) -> None:
    edges = np.array([first, second, height])
    (seen,) = hexagons(JACOBIANS, np.array([turn]), edges[None])
    assert apart(fit_box(JACOBIANS, seen).heading, turn) < 3.0


@pytest.mark.parametrize("turn", np.radians([0, 8, 20, 37, 45, 61, 88]))
def test_fit_of_pixels_returns_the_heading_of_a_cube(turn: float) -> None:
    box = fit_box(JACOBIANS, photographed(turn, np.full(3, 0.042)))
    assert apart(box.heading, turn) < 5.0
    np.testing.assert_allclose(box.edges, 0.042, rtol=0.15)
    assert box.contrast > 1.5


@given(heading)
def test_fit_of_a_long_box_tells_its_edges_apart(turn: float) -> None:
    (seen,) = hexagons(JACOBIANS, np.array([turn]), np.array([[0.1, 0.03, 0.03]]))
    box = fit_box(JACOBIANS, seen)
    along = box.heading if box.edges[0] > box.edges[1] else box.heading + math.pi / 2
    assert math.degrees(abs(math.sin(along - turn))) < 3.0
