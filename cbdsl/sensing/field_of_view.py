"""The field of view: where the cameras were at their newest images, and what the hands hide."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import RobotDocument
from cbdsl.numeric.compiled import compiled_once
from cbdsl.sensing.camera import within_view
from cbdsl.sensing.kinematics import Frame, Kinematics

Floats = NDArray[np.float64]
Ball = tuple[Floats, float]
"""A centre, m, world frame, shape (3,), and a radius, m."""

# A hidden thing lies at most this much behind the hand that hides it, m.
_BEHIND_HAND = 0.1
# Fingertips that touch a thing are about a radius from its middle; within this share of it, and
# feeling nothing, they have closed on air.
_INSIDE = 0.75


class FieldOfView:
    """Tells which places the cameras show, and what may hide them.

    Attributes:
        frames: of the cameras at their newest images, by name.
        posture: in which the newest images were taken, rad, shape (n,); ``None`` before any.
    """

    def __init__(self, robot: RobotDocument, kinematics: Kinematics) -> None:
        self._cameras = robot.cameras
        self._kinematics = kinematics
        self._hand_radius = robot.vision.regions.hand_radius
        # Upper arms are thin and seldom in view; what hides things is the wrist and the hand.
        self._wrists = tuple(
            effector.joints[-1] for effector in robot.effectors.values() if effector.tip is not None
        )
        tips = [each.tip.link for each in robot.effectors.values() if each.tip is not None]
        fingers = [[cell.link for cell in hand.values()] for hand in robot.load_cells.values()]
        self._hand_links = (*tips, *(link for hand in fingers for link in hand))
        ends = np.cumsum([len(self._wrists) + len(tips), *map(len, fingers)]).tolist()
        #: By hand, which of the points that may hide things are its fingertips.
        self._fingers = [slice(start, end) for start, end in itertools.pairwise(ends)]
        self.reset()

    def reset(self) -> None:
        """Forget where the cameras were."""
        self.frames: dict[str, Frame] = {}
        # No line of sight leaves a camera that has not seen anything yet.
        self._eyes: Floats = np.full((len(self._cameras), 3), math.nan)
        self._hands: Floats | None = None
        self.posture: Floats | None = None

    def renew(self, posture: Floats) -> None:
        """Take in that there are new images; hands are placed when they are asked for.

        Args:
            posture: in which the images were taken, rad, shape (n,).
        """
        self._hands, self.posture = None, posture

    def placed(self, links: tuple[str, ...]) -> list[Frame]:
        """The placements of links when the newest images were taken."""
        assert self.posture is not None
        with self._kinematics.posed(self.posture):
            return self._kinematics.placed(links)

    def place(self, row: int, name: str, frame: Frame) -> None:
        """Take in where a camera, the ``row``-th, was at its newest image."""
        self.frames[name] = frame
        self._eyes[row] = frame.position

    @property
    def middle(self) -> Floats:
        """The middle between the cameras, m, shape (3,)."""
        mean: Floats = self._eyes.mean(axis=0)
        return mean

    def views(self, position: Floats, radius: float) -> list[bool]:
        """Whether the whole of a ball is in each camera's image, unless something hides it."""
        return [
            within_view(
                self._cameras[name], frame.rotation.T.dot(position - frame.position), radius
            )
            for name, frame in self.frames.items()
        ]

    def shows(self, position: Floats, radius: float) -> bool:
        """Whether the whole of a ball is in some camera's image, unless something hides it."""
        return True in self.views(position, radius)

    def hidden_by(self, ball: Ball, others: Iterable[Ball]) -> list[bool]:
        """Whether other balls hide half of a ball or more from each camera."""
        balls, (position, radius) = list(others), ball
        return [
            any(_is_before(eye, centre, size + radius / 2, position) for centre, size in balls)
            for eye in self._eyes
        ]

    def is_hidden_by_hand(self, position: Floats) -> bool:
        """Whether a wrist, palm or fingertip is near some camera's line of sight to a position."""
        if self._hands is None and self.posture is not None:
            with self._kinematics.posed(self.posture):
                self._hands = self._kinematics.origins(self._wrists, self._hand_links)
        if self._hands is None:
            return False
        return _is_beside(self._hands, self._eyes, position, self._hand_radius)

    def hands_have_closed_on(self, position: Floats, radius: float) -> bool:
        """Whether all fingertips of a hand were inside of a ball when the cameras last looked.

        Only what is hidden may be somewhere else than it is remembered: false where nobody has
        asked since whether a hand hides anything.
        """
        if self._hands is None:
            return False
        return any(
            _are_within(self._hands[fingers], position, _INSIDE * radius)
            for fingers in self._fingers
        )


def _is_before(eye: Floats, centre: Floats, radius: float, position: Floats) -> bool:
    """Whether a ball is between an eye and a position."""
    line, offset = position - eye, centre - eye
    distance = math.sqrt(line.dot(line))
    along = float(offset.dot(line)) / distance
    across = float(offset.dot(offset)) - along * along
    return 0.0 < along < distance and across < radius * radius


@compiled_once
def _are_within(points: Floats, center: Floats, radius: float) -> bool:
    """Whether all points, shape (n, 3), are nearer to a center, shape (3,), than a radius, m."""
    for point in points:
        x, y, z = point[0] - center[0], point[1] - center[1], point[2] - center[2]
        if x * x + y * y + z * z >= radius * radius:
            return False
    return True


@compiled_once
def _is_beside(points: Floats, eyes: Floats, position: Floats, radius: float) -> bool:
    """Whether one of some points, shape (n, 3), is near the line of sight from one of the eyes.

    Args:
        points: m, shape (n, 3).
        eyes: m, shape (k, 3).
        position: what they look at, m, shape (3,).
        radius: how near, m.
    """
    for eye in eyes:
        line = position - eye
        distance = math.sqrt(line[0] ** 2 + line[1] ** 2 + line[2] ** 2)
        for point in points:
            x, y, z = point[0] - eye[0], point[1] - eye[1], point[2] - eye[2]
            along = (x * line[0] + y * line[1] + z * line[2]) / distance
            across = x * x + y * y + z * z - along * along
            if across < radius * radius and 0 < along < distance + _BEHIND_HAND:
                return True
    return False
