"""Measure of localizability (Section 3.1.3 c, Eq 3.6).

phi = 1 / sqrt(det(J^T J)), with J the sensitivity of two headings to displacements. As in the
source, a heading is one angle (SO(2), Table 3.1). It is the angle at a camera in the plane through
both cameras and the seen point. J is their derivative by displacements of the point in that plane,
2 x 2. The point has the distances r_l and r_r from the cameras and d from the baseline b. Then phi
= (r_l r_r)^2 / (b d), in m^2/rad^2. It falls to 0 as the point comes near a camera. (The source
prints the inverse Jacobian, with which phi would rise instead.) A baseline of 36.5 cm gives the
ratios of Table 3.2 within 2.2 %. With azimuth and elevation, J of shape (4, 3), no baseline does
within 7 %.

The feedback consists of azimuth and elevation of both cameras. They determine the point: the middle
between the lines of sight at their nearest approach.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cbdsl.control.potential import Potential, Rule, potential
from cbdsl.control.setting import Setting
from cbdsl.kinematics.kinematics import Frame
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled
from cbdsl.numeric.vector import add, copy, dot, norm
from cbdsl.program.controller import Controller
from cbdsl.sensing.vision.association.stereo import cross_rays

# Smallest height above the baseline, in baselines; on it phi has no bound and no gradient.
_NO_HEIGHT = 1e-6


def build(controller: Controller, setting: Setting) -> Potential:
    """Return the localizability of a controller by the robot's cameras.

    Raises:
        ValueError: If there are not two cameras, or they are in the same place.
    """
    return seen_by(setting.cameras)


def seen_by(cameras: Sequence[Frame]) -> Potential:
    """Return the localizability by a left and a right camera, in one frame that moves with them."""
    if len(cameras) != 2:
        raise ValueError("localizability needs two cameras that keep their distance")
    if not np.linalg.norm(cameras[0].position - cameras[1].position) > 0.0:
        raise ValueError("localizability needs two cameras with a distance between them")
    parameters = [part.ravel() for camera in cameras for part in camera]
    return Potential(uncertainty, 1, Rule.TO_ZERO, np.concatenate(parameters), refuse=_refuse)


def _refuse(value: Floats, reference: Floats) -> str:
    return "the lines of sight do not meet in front of both cameras, away from their baseline"


@potential
def uncertainty(
    value: Floats, reference: Floats, parameters: Floats, residual: Floats, slope: Floats
) -> float:
    """Return phi of two headings, rad; parameters: the cameras' positions and rotations."""
    left, right = parameters[:3], parameters[12:15]
    rays, turns, point, gradient = np.empty((2, 3)), np.empty((2, 3)), np.empty(3), np.empty(3)
    for eye in range(2):
        _look(parameters[12 * eye + 3 :], value[2 * eye], value[2 * eye + 1], rays[eye])
    if math.isnan(cross_rays(left, rays[0], 1.0, right, rays[1], 1.0, point)):
        return math.nan
    phi = _square_of_distances(left, right, point, gradient)
    if math.isnan(phi):
        return math.nan
    _differentiate_by_rays(gradient, point, left, right, rays, turns)
    for eye in range(2):
        _differentiate_by_heading(parameters[12 * eye + 3 :], turns[eye], value, eye, slope[0])
    residual[0] = -phi
    return phi


@compiled
def _look(rotation: Floats, azimuth: float, elevation: float, ray: Floats) -> None:
    """Write the unit vector of a heading, turned by a row-major rotation, shape (3,)."""
    level = math.cos(elevation)
    x, y, z = level * math.cos(azimuth), level * math.sin(azimuth), math.sin(elevation)
    for i in range(3):
        ray[i] = rotation[3 * i] * x + rotation[3 * i + 1] * y + rotation[3 * i + 2] * z


@compiled
def _differentiate_by_heading(
    rotation: Floats, turn: Floats, value: Floats, eye: int, slope: Floats
) -> None:
    """Write the derivative by a camera's heading from that by its line of sight."""
    own = np.empty(3)
    for k in range(3):
        own[k] = rotation[k] * turn[0] + rotation[3 + k] * turn[1] + rotation[6 + k] * turn[2]
    azimuth, elevation = value[2 * eye], value[2 * eye + 1]
    level, up = math.cos(elevation), math.sin(elevation)
    forward, left = math.cos(azimuth), math.sin(azimuth)
    slope[2 * eye] = level * (forward * own[1] - left * own[0])
    slope[2 * eye + 1] = level * own[2] - up * (forward * own[0] + left * own[1])


@compiled
def _square_of_distances(left: Floats, right: Floats, point: Floats, gradient: Floats) -> float:
    """Return phi and write its gradient by the point, shape (3,); NaN on the baseline's line."""
    baseline, to_left, to_right, across = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for i in range(3):
        baseline[i] = right[i] - left[i]
        to_left[i], to_right[i] = point[i] - left[i], point[i] - right[i]
    length = norm(baseline)
    copy(across, to_left, 1.0)
    add(across, baseline, -dot(baseline, to_left) / (length * length))
    height = dot(across, across)
    if not height > (_NO_HEIGHT * length) ** 2:
        return math.nan
    left_square, right_square = dot(to_left, to_left), dot(to_right, to_right)
    phi: float = left_square * right_square / (length * math.sqrt(height))
    copy(gradient, to_left, 2.0 * phi / left_square)
    add(gradient, to_right, 2.0 * phi / right_square)
    add(gradient, across, -phi / height)
    return phi


@compiled
def _differentiate_by_rays(
    by_point: Floats, point: Floats, left: Floats, right: Floats, rays: Floats, turns: Floats
) -> None:
    """Write the gradient by the lines of sight from that by the triangulated point.

    The point x minimises the sum of its squared distances from both lines. With their origins o and
    directions u, A x = sum (I - u u^T) o, where A = sum (I - u u^T). A change du of one direction
    moves it by A^-1 ((u . s) du + u (du . s)), s = x - o. The gradient g enters by y = A^-1 g,
    which is (g + a u_l + b u_r) / 2, where a = y . u_l and b = y . u_r.

    Args:
        by_point: Gradient g by the triangulated point, shape (3,).
        point: Triangulated point x, m, shape (3,).
        left: Position of the left camera, m, shape (3,).
        right: Position of the right camera, m, shape (3,).
        rays: Unit directions of the left and the right line of sight, shape (2, 3).
        turns: Becomes the gradient by the left, then the right direction, shape (2, 3).
    """
    cosine = dot(rays[0], rays[1])
    along_left, along_right = dot(by_point, rays[0]), dot(by_point, rays[1])
    sine_square = 1.0 - cosine * cosine
    y, to_eye = np.empty(3), np.empty(3)
    a = (along_left + cosine * along_right) / sine_square
    b = (along_right + cosine * along_left) / sine_square
    for i in range(3):
        y[i] = 0.5 * (by_point[i] + a * rays[0, i] + b * rays[1, i])
    for eye in range(2):
        origin, along = (left, a) if eye == 0 else (right, b)
        for i in range(3):
            to_eye[i] = point[i] - origin[i]
        copy(turns[eye], y, dot(rays[eye], to_eye))
        add(turns[eye], to_eye, along)
