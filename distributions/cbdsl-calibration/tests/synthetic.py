"""Synthetic views of a ball in Dexter's right hand, by cameras with known displacements."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cbdsl.documents.model import Kernel, ModelDocument
from cbdsl.documents.robot import Correction, RobotDocument
from cbdsl.kinematics.forward import rotation_of
from cbdsl.kinematics.kinematics import Frame, Kinematics
from cbdsl.numeric.arrays import Floats
from cbdsl_calibration.ball import image
from cbdsl_calibration.hand_view import HandView

RADIUS = 0.07
#: Centre of the ball in the frame of the palm, m.
IN_HAND = np.array((0.002, -0.024, 0.073))
# Pan and tilt towards the place where the hand shows it.
_LOOK = np.array((-0.63, 0.93))


def draw_corrections(
    rng: np.random.Generator, distance: float, angle: float, names: tuple[str, ...]
) -> dict[str, Correction]:
    """Return displacements of cameras by a distance and an angle in random directions."""

    def vector(length: float) -> tuple[float, float, float]:
        direction = rng.standard_normal(3)
        x, y, z = (length * direction / np.linalg.norm(direction)).tolist()
        return x, y, z

    return {name: Correction(position=vector(distance), rotation=vector(angle)) for name in names}


def frame_of(frame: Frame, correction: Correction) -> Frame:
    """Return the frame of a displaced camera."""
    position = frame.position + frame.rotation @ np.array(correction.position)
    return Frame(position, frame.rotation @ rotation_of(np.array(correction.rotation)))


class ShownBall:
    """Shows a ball in sampled postures.

    Args:
        robot: Robot document of Dexter.
        kinematics: Kinematics of the robot.
        model: Sampler of the arm's postures.
        rng: Random generator for all samples.
        spread: Share of the differences between the postures.
        in_hand: Centre of the ball in the frame of the palm, m, shape (3,).
    """

    def __init__(
        self,
        robot: RobotDocument,
        kinematics: Kinematics,
        model: ModelDocument,
        rng: np.random.Generator,
        spread: float = 1.0,
        in_hand: Floats = IN_HAND,
    ) -> None:
        assert isinstance(model.density, Kernel)
        self._robot, self._kinematics = robot, kinematics
        self._samples = np.array(model.density.samples)
        self._bandwidth = np.array(model.density.bandwidth)
        self._rng, self._spread, self._in_hand = rng, spread, in_hand

    def views(
        self, true: Mapping[str, Correction], count: int, noise: float, lasting: float = 0.0
    ) -> list[HandView]:
        """Return views by all cameras in ``count`` postures.

        Args:
            true: Displacements of the cameras.
            count: Number of postures.
            noise: Standard deviation of image points, px.
            lasting: Standard deviation of errors that each tenth of the postures shares, px.
        """
        views: list[HandView] = []
        for number in range(count):
            if number * 10 // count != (number - 1) * 10 // count:
                common = {name: lasting * self._rng.standard_normal(2) for name in true}
            views += [
                view._replace(point=view.point + common[view.camera])
                for view in self._posture(true, noise)
            ]
        return views

    def _posture(self, true: Mapping[str, Correction], noise: float) -> list[HandView]:
        kinematics, rng = self._kinematics, self._rng
        middle = self._samples.mean(axis=0)
        drawn = self._samples[rng.integers(len(self._samples))]
        drawn = drawn + self._bandwidth * rng.standard_normal(7)
        posture = np.zeros(len(kinematics.joints))
        posture[kinematics.joints.of("right_arm")] = middle + self._spread * (drawn - middle)
        wandering = 0.06 * self._spread * rng.standard_normal(2)
        posture[kinematics.joints.of("head")] = _LOOK + wandering
        posture[kinematics.joints.of("right_hand")] = 0.3, 0.75, 0.75, 0.75
        kinematics.update(posture)
        palm = kinematics.frame("right_palm")
        ball = palm.position + palm.rotation @ self._in_hand
        cells = self._robot.load_cells["right_hand"].values()
        tips = np.array([kinematics.frame(cell.link).position for cell in cells])
        views = []
        for name, camera in self._robot.cameras.items():
            model = kinematics.frame(camera.link)
            eye = frame_of(model, true[name])
            inside = eye.rotation.T @ (ball - eye.position)
            (point,), (area,) = image(camera, inside[None], RADIUS)
            seen = point + noise * rng.standard_normal(2)
            views.append(HandView(name, *model, seen, area, tips))
        return views
