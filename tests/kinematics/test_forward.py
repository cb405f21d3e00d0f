"""Points of links: their Jacobians and curvatures, by finite differences, passive joints too."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.kinematics.kinematics import Kinematics
from tests.kinematics.test_kinematics import LINKS

OFFSET = (0.02, -0.01, 0.07)
STEP = 1e-6


@pytest.mark.parametrize("link", LINKS)
def test_points_move_as_their_jacobian_says(
    kinematics: Kinematics, posture: np.ndarray, link: str
) -> None:
    kinematics.update(posture)
    here = kinematics.point(link, OFFSET)
    for column, change in enumerate(STEP * np.eye(len(posture))):
        kinematics.update(posture + change)
        ahead = kinematics.point(link, OFFSET).position
        kinematics.update(posture - change)
        moved = (ahead - kinematics.point(link, OFFSET).position) / (2 * STEP)
        assert here.jacobian[:3, column] == pytest.approx(moved, abs=1e-8)


@pytest.mark.parametrize("link", LINKS)
@pytest.mark.parametrize("rows", [3, 6])
def test_curvature_is_the_derivative_of_the_jacobian(
    kinematics: Kinematics, posture: np.ndarray, link: str, rows: int
) -> None:
    kinematics.update(posture)
    curvature = kinematics.curvature(link, kinematics.point(link, OFFSET).position, rows)
    for joint, change in enumerate(STEP * np.eye(len(posture))):
        kinematics.update(posture + change)
        ahead = kinematics.point(link, OFFSET).jacobian
        kinematics.update(posture - change)
        bent = (ahead - kinematics.point(link, OFFSET).jacobian) / (2 * STEP)
        assert curvature[:, :, joint] == pytest.approx(bent[:rows], abs=1e-7)


def test_frames_of_an_earlier_posture_do_not_change(
    kinematics: Kinematics, posture: np.ndarray
) -> None:
    """Pinocchio writes new postures over old ones; frames of earlier images must not change."""
    kinematics.update(posture)
    frame, point = kinematics.frame("right_palm"), kinematics.point("right_palm", OFFSET)
    copies = [each.copy() for each in (frame.position, frame.rotation, *point)]
    kinematics.update(posture + 0.1)
    for copy, kept in zip(copies, (frame.position, frame.rotation, *point), strict=True):
        np.testing.assert_array_equal(copy, kept)
    assert not np.allclose(kinematics.point("right_palm", OFFSET).position, point.position)
