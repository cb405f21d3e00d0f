"""Association: two cameras see things side by side, behind each other, cut off, and no ghosts."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.documents.robot import Regions
from cbdsl.sensing.channels import Moments, Region
from cbdsl.sensing.vision.association.association import pair
from cbdsl.sensing.vision.association.sighting import Sighting
from cbdsl.sensing.vision.association.stereo import Ray

SETTINGS = Regions()
FOCAL, WIDTH, HEIGHT = 418.5, 320, 240
EYES = (np.array([0.24, 0.15, 0.5]), np.array([0.24, -0.15, 0.5]))
MIDDLE = np.array([0.6, 0.0, -0.36])
Ball = tuple[np.ndarray, float]


def camera(eye: np.ndarray) -> np.ndarray:
    """Return the axes of a camera that looks at the middle: ahead, left, up."""
    ahead = (MIDDLE - eye) / np.linalg.norm(MIDDLE - eye)
    left = np.cross([0.0, 0.0, 1.0], ahead)
    left /= np.linalg.norm(left)
    return np.array([ahead, left, np.cross(ahead, left)]).T


def sighting(eye: np.ndarray, ball: Ball, noise: float = 0.0) -> Sighting | None:
    """Return the sighting of a ball in the image of a camera, or ``None`` out of view."""
    axes, (centre, radius) = camera(eye), ball
    x, y, z = axes.T @ (centre - eye)
    column, row = WIDTH / 2 - FOCAL * y / x + noise, HEIGHT / 2 - FOCAL * z / x - noise
    half = FOCAL * radius / x
    if not (0 < column < WIDTH and 0 < row < HEIGHT):
        return None
    clipped = min(column, row, WIDTH - column, HEIGHT - row) <= half
    slopes = np.array([1.0, (WIDTH / 2 - column) / FOCAL, (HEIGHT / 2 - row) / FOCAL])
    length = float(np.linalg.norm(slopes))
    area = round(math.pi * radius**2 * FOCAL**2 / (x**2 * length**-1))
    region = Region(area, column, row, clipped, Moments(half**2 / 4, 0.0, half**2 / 4))
    return Sighting(region, Ray(eye, axes @ slopes, length), length**-3, FOCAL, 0.0, 1)


def seen(balls: list[Ball], noise: float = 0.0) -> list[list[Sighting]]:
    """Return sightings of both cameras, the largest region first."""
    return [
        sorted(
            (each for ball in balls if (each := sighting(eye, ball, sign * noise)) is not None),
            key=lambda each: -each.region.area,
        )
        for eye, sign in zip(EYES, (1, -1), strict=True)
    ]


def aside(distance: float) -> np.ndarray:
    """Return a place to the left of the middle."""
    return MIDDLE + np.array([0.0, distance, 0.0])


place = st.tuples(st.floats(0.4, 0.8), st.floats(-0.3, 0.3), st.floats(0.03, 0.08))


@given(places=st.lists(place, min_size=2, max_size=4), noise=st.floats(-0.3, 0.3))
def test_unambiguous_correspondence_is_a_real_object(
    places: list[tuple[float, ...]], noise: float
) -> None:
    """Balls on a table, some of them out of one camera's view or of both, with noisy centroids."""
    balls: list[Ball] = []
    for x, y, radius in places:
        centre = np.array([x, y, -0.42 + radius])
        if all(math.dist(centre, c) > 1.5 * (radius + r) for c, r in balls):
            balls.append((centre, radius))
    certain, _ = pair(*seen(balls, noise), SETTINGS)
    for each in certain:
        if each.whole:
            assert min(math.dist(each.meeting.position, c) for c, _ in balls) < 0.01


@pytest.mark.parametrize("apart", [0.1, 0.15, 0.2])
def test_equal_things_on_one_plane_are_distinguished_by_their_order(apart: float) -> None:
    """Let each line of sight meet both of the other camera's, at as plausible sizes."""
    balls = [(aside(y), 0.04) for y in (-apart / 2, apart / 2)]
    left, right = seen(balls)
    every = [candidate for one in left for candidate in pair([one], right, SETTINGS)[1]]
    assert len(every) >= 2, "both pairings are possible"
    certain, ambiguous = pair(left, right, SETTINGS)
    assert len(certain) == 2 and not ambiguous
    for each in certain:
        assert min(math.dist(each.meeting.position, c) for c, _ in balls) < 0.005


def test_region_that_matches_two_is_ambiguous() -> None:
    """Let the other camera's only region show either of them."""
    balls = [(aside(y), 0.04) for y in (-0.06, 0.06)]
    left, right = seen(balls)
    for only in right:
        certain, ambiguous = pair(left, [only], SETTINGS)
        assert not certain
        assert len(ambiguous) == 2


def test_sizes_that_do_not_agree_are_no_pair() -> None:
    small, large = (aside(0.05), 0.03), (aside(-0.05), 0.08)
    left, right = seen([small, large])
    assert left[0].region.area > 2 * left[1].region.area
    assert pair([left[0]], [right[1]], SETTINGS) == ([], [])
