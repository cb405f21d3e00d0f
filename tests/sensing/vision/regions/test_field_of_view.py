"""Occlusion of places in the cameras: other objects, wrists and hands."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Frame, Kinematics
from cbdsl.sensing.vision.regions.field_of_view import FieldOfView

FAR = np.array([0.0, 0.0, 50.0])


@pytest.fixture
def field(dexter: RobotDocument, kinematics: Kinematics) -> FieldOfView:
    """Return a field with one camera at the origin, and one far above it."""
    made = FieldOfView(dexter, kinematics)
    for name, place in zip(dexter.cameras, (np.zeros(3), FAR), strict=True):
        made.place(name, Frame(place, np.eye(3)))
    return made


@pytest.mark.parametrize(
    ("centre", "hides"),
    [
        ((1.0, 0.24, 0.0), True),
        ((1.0, 0.0, -0.26), False),
        ((1.99, 0.0, -0.1), True),
        ((2.01, 0.0, -0.1), False),
        ((0.01, 0.1, 0.0), True),
        ((-0.01, 0.1, 0.0), False),
    ],
)
def test_object_in_front_hides_another_up_to_half_its_radius(
    field: FieldOfView, centre: tuple[float, float, float], hides: bool
) -> None:
    """Occlude it if its line of sight passes within the other's radius plus half of its own."""
    ball, other = (np.array([2.0, 0.0, 0.0]), 0.1), (np.array(centre), 0.2)
    assert field.hidden_by(ball, [other]) == [hides, False]
    assert field.hidden_by(ball, iter([(np.array([9.0, 9.0, 0.0]), 0.1), other]))[0] is hides
    assert field.hidden_by(ball, []) == [False, False]


def test_no_object_is_hidden_before_the_first_image(
    dexter: RobotDocument, kinematics: Kinematics, field: FieldOfView
) -> None:
    fresh = FieldOfView(dexter, kinematics)
    ball = np.array([2.0, 0.0, 0.0])
    assert fresh.hidden_by((ball, 0.1), [(ball / 2, 0.2)]) == [False, False]
    assert not fresh.is_hidden_by_hand(ball) and not fresh.shows(ball, 0.1)
    assert not fresh.hands_have_closed_on(ball, 9.0)
    assert field.middle == pytest.approx(FAR / 2)
    field.reset()
    assert field.frames == {} and np.isnan(field.middle).all()


def hand_points(dexter: RobotDocument, kinematics: Kinematics, posture: np.ndarray) -> np.ndarray:
    """Return wrists, palms and fingertips in a posture, m, shape (k, 3)."""
    kinematics.update(posture)
    tips = [each.tip.link for each in dexter.effectors.values() if each.tip is not None]
    cells = [cell.link for hand in dexter.load_cells.values() for cell in hand.values()]
    wrists = [each.joints[-1] for each in dexter.effectors.values() if each.tip is not None]
    return kinematics.origins(tuple(wrists), (*tips, *cells)).copy()


def test_hand_hides_points_near_the_line_behind_it(
    dexter: RobotDocument, kinematics: Kinematics, field: FieldOfView
) -> None:
    rng, hidden = np.random.default_rng(6), []
    posture = rng.uniform(kinematics.lower, kinematics.upper)
    points, radius = hand_points(dexter, kinematics, posture), dexter.vision.regions.hand_radius
    kinematics.update(np.zeros_like(posture))
    field.renew(posture)
    for _ in range(150):
        place = points[rng.integers(len(points))] + rng.normal(0.0, 0.2, 3)
        expected = False
        for eye in (np.zeros(3), FAR):
            distance = math.dist(eye, place)
            along = (points - eye) @ (place - eye) / distance
            across = np.linalg.norm(np.cross(points - eye, place - eye), axis=1) / distance
            expected |= bool(((across < radius) & (along > 0) & (along < distance + 0.1)).any())
        assert field.is_hidden_by_hand(place) is expected
        hidden.append(expected)
    assert 20 < sum(hidden) < 130


def test_fingers_have_closed_on_an_object_that_contains_all_tips(
    dexter: RobotDocument, kinematics: Kinematics, field: FieldOfView
) -> None:
    posture = np.random.default_rng(7).uniform(kinematics.lower, kinematics.upper)
    hand_points(dexter, kinematics, posture)
    for hand, cells in dexter.load_cells.items():
        tips = np.array([kinematics.frame(cell.link).position for cell in cells.values()])
        middle = tips.mean(axis=0)
        least = np.linalg.norm(tips - middle, axis=1).max() / 0.75
        field.renew(posture)
        assert not field.hands_have_closed_on(middle, 1.01 * least), "nobody asked what hides it"
        field.is_hidden_by_hand(middle)
        assert field.hands_have_closed_on(middle, 1.01 * least), hand
        assert not field.hands_have_closed_on(middle, 0.99 * least), hand
