"""The measure of localizability (Section 3.1.3 c, Eq 3.6)."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.control.body import Body
from cbdsl.control.potential import Evaluation, newton
from cbdsl.control.signal import Floats, Signal, SignalError
from cbdsl.program.controller import Controller
from cbdsl.sensing.camera import direction
from cbdsl.sensing.kinematics import Frame
from cbdsl.sensing.stereo import Ray, triangulate

# Heights above the baseline, in baselines, that are none: there phi has no bound and no gradient.
_NO_HEIGHT = 1e-6


class Localizability:
    """phi = 1 / sqrt(det(J^T J)), with J the sensitivity of two headings to displacements.

    The headings are those of the source, one angle each (SO(2), Table 3.1): the angles at the two
    cameras in the plane through both and the seen point. J is their derivative by displacements
    of the point in that plane, 2 x 2. With the point's distances r_l and r_r from the cameras and
    d from the baseline b, phi = (r_l r_r)^2 / (b d), in m^2/rad^2. It falls to 0 as the point
    comes near a camera. (Printed is the inverse Jacobian, with which phi would rise instead.)
    A baseline of 36.5 cm gives the ratios of Table 3.2 within 2.2 %; with azimuth and elevation, J
    of shape (4, 3), no baseline does within 7 %.

    The feedback has azimuth and elevation of both cameras. They are a function of the point, the
    middle between the lines of sight where these come nearest to each other.

    Args:
        cameras: the left and the right camera, in one frame that moves with them.

    Raises:
        ValueError: there are not two cameras, or they are in the same place.
    """

    def __init__(self, cameras: tuple[Frame, ...]) -> None:
        if len(cameras) != 2:
            raise ValueError("localizability needs two cameras that keep their distance")
        self.size = 1
        self.compiled = None
        self._cameras = cameras
        baseline = cameras[1].position - cameras[0].position
        self._baseline = math.sqrt(baseline.dot(baseline))
        if not self._baseline > 0.0:
            raise ValueError("localizability needs two cameras with a distance between them")
        self._along = baseline / self._baseline

    @classmethod
    def build(cls, controller: Controller, body: Body) -> Localizability:
        """The localizability of a checked controller as the body's cameras see."""
        return cls(body.cameras)

    def evaluate(self, signal: Signal, reference: Floats | None) -> Evaluation:
        """See ``Potential.evaluate``; the reference plays no part.

        Args:
            signal: azimuth and elevation in the left, then in the right camera, rad.
            reference: not used.
        """
        if signal.value.shape != (4,):
            raise SignalError(
                f"localizability needs two headings, but {signal.name} "
                f"has shape {signal.value.shape}"
            )
        headings = signal.value[:2], signal.value[2:]
        left, right = (
            Ray(camera.position, camera.rotation.dot(direction(heading)))
            for camera, heading in zip(self._cameras, headings, strict=True)
        )
        crossing = triangulate(left, right)
        if crossing is None:
            raise SignalError(
                f"the lines of sight of {signal.name} do not meet in front of both cameras"
            )
        potential = self._potential(crossing.position)
        if potential is None:
            raise SignalError(
                f"the lines of sight of {signal.name} meet on the line through both cameras"
            )
        phi, by_point = potential
        turns = _by_turns(by_point, crossing.position, left, right)
        by_heading = [
            camera.rotation.T.dot(turn).dot(_direction_jacobian(heading))
            for camera, turn, heading in zip(self._cameras, turns, headings, strict=True)
        ]
        return newton(phi, np.concatenate(by_heading).dot(signal.jacobian))

    def _potential(self, point: Floats) -> tuple[float, Floats] | None:
        """phi and its gradient by the point, shape (3,); ``None`` on the line of the baseline."""
        left, right = (point - camera.position for camera in self._cameras)
        across = left - self._along.dot(left) * self._along
        height_square = float(across.dot(across))
        if not height_square > (_NO_HEIGHT * self._baseline) ** 2:
            return None
        left_square, right_square = float(left.dot(left)), float(right.dot(right))
        phi = left_square * right_square / (self._baseline * math.sqrt(height_square))
        logarithmic = 2 * left / left_square + 2 * right / right_square - across / height_square
        return phi, phi * logarithmic


def _by_turns(by_point: Floats, point: Floats, left: Ray, right: Ray) -> tuple[Floats, Floats]:
    """A gradient by the directions of the lines of sight, from that by the triangulated point.

    The point x minimises the sum of its squared distances from both lines: with their origins o
    and directions u, A x = sum (I - u u^T) o, where A = sum (I - u u^T). A change du of one
    direction moves it by A^-1 ((u . s) du + u (du . s)), s = x - o. The gradient g enters by
    y = A^-1 g, which is (g + a u_l + b u_r) / 2, where a = y . u_l and b = y . u_r.
    """
    cosine = left.direction.dot(right.direction)
    along_left, along_right = by_point.dot(left.direction), by_point.dot(right.direction)
    sine_square = 1.0 - cosine * cosine
    a = (along_left + cosine * along_right) / sine_square
    b = (along_right + cosine * along_left) / sine_square
    y = 0.5 * (by_point + a * left.direction + b * right.direction)
    to_left, to_right = point - left.origin, point - right.origin
    return (
        left.direction.dot(to_left) * y + a * to_left,
        right.direction.dot(to_right) * y + b * to_right,
    )


def _direction_jacobian(heading: Floats) -> Floats:
    """Change of the unit vector with a heading per azimuth and elevation, shape (3, 2)."""
    azimuth, elevation = heading.tolist()
    level, up = math.cos(elevation), math.sin(elevation)
    forward, left = math.cos(azimuth), math.sin(azimuth)
    return np.array([[-level * left, -up * forward], [level * forward, -up * left], [0.0, level]])
