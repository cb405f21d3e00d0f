"""Field of view: camera placements at the newest images, and occlusion by hands and objects."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable

import numpy as np

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Frame, Kinematics
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled_once
from cbdsl.sensing.vision.regions.camera import within_view

Ball = tuple[Floats, float]
"""A centre, m, world frame, shape (3,), and a radius, m."""

# An occluded object lies at most this far behind the hand that occludes it, m.
_BEHIND_HAND = 0.1
# Round fingertips that touch an object are about a radius from its middle, and flat pads on the
# faces of a box at least 0.58 radii. Within these shares, without contact, they have closed on air.
_INSIDE, _PADS_INSIDE = 0.75, 0.5


class FieldOfView:
    """Visibility and occlusion of places in the newest images of the main cameras.

    Attributes:
        frames: Camera frames at their newest images, by name.
        posture: Posture at the newest images, rad, shape (n,); ``None`` before any.
    """

    def __init__(self, robot: RobotDocument, kinematics: Kinematics) -> None:
        self._cameras = robot.main_cameras
        self._rows = {name: row for row, name in enumerate(self._cameras)}
        self._kinematics = kinematics
        self._hand_radius = robot.vision.regions.hand_radius
        # Upper arms are thin and seldom in view; wrists and hands occlude objects.
        self._wrists = tuple(
            effector.joints[-1] for effector in robot.effectors.values() if effector.tip is not None
        )
        tips = [each.tip.link for each in robot.effectors.values() if each.tip is not None]
        hands = robot.load_cells.values()
        fingers = [[cell.link for cell in hand.values()] for hand in hands]
        are_round = [all(cell.radius > 0.0 for cell in hand.values()) for hand in hands]
        self._shares = [_INSIDE if each else _PADS_INSIDE for each in are_round]
        self._hand_links = (*tips, *(link for hand in fingers for link in hand))
        ends = np.cumsum([len(self._wrists) + len(tips), *map(len, fingers)]).tolist()
        #: Slices of the occluding points that are a hand's fingertips, by hand.
        self._fingers = [slice(start, end) for start, end in itertools.pairwise(ends)]
        self.reset()

    def reset(self) -> None:
        """Forget where the cameras were."""
        self.frames: dict[str, Frame] = {}
        # A camera without any image has no line of sight.
        self._eyes: Floats = np.full((len(self._cameras), 3), math.nan)
        self._hands: Floats | None = None
        self.posture: Floats | None = None

    def renew(self, posture: Floats) -> None:
        """Set the posture of new images; hands are placed on demand.

        Args:
            posture: Posture at the exposure of the images, rad, shape (n,).
        """
        self._hands, self.posture = None, posture

    def placed(self, links: tuple[str, ...]) -> list[Frame]:
        """Return the placements of links at the newest images."""
        assert self.posture is not None
        return self._kinematics.posed(self.posture, lambda: self._kinematics.placed(links))

    def place(self, name: str, frame: Frame) -> None:
        """Set the placement of a camera at its newest image."""
        self.frames[name] = frame
        if name in self._rows:
            self._eyes[self._rows[name]] = frame.position

    @property
    def middle(self) -> Floats:
        """Middle between the main cameras, m, world frame, shape (3,)."""
        mean: Floats = self._eyes.mean(axis=0)
        return mean

    def views(self, position: Floats, radius: float) -> list[bool]:
        """Return for each camera whether its image would show a whole ball without occlusion."""
        return [
            within_view(camera, frame.rotation.T.dot(position - frame.position), radius)
            for name, camera in self._cameras.items()
            if (frame := self.frames.get(name)) is not None
        ]

    def shows(self, position: Floats, radius: float) -> bool:
        """Return whether some camera's image would show a whole ball without occlusion."""
        return True in self.views(position, radius)

    def hidden_by(self, ball: Ball, others: Iterable[Ball]) -> list[bool]:
        """Return for each camera whether another ball occludes a ball within half its radius.

        A large ball then covers a fifth of it or more, which shifts the centroid of its region.
        """
        balls, (position, radius) = list(others), ball
        return [
            any(_is_before(eye, centre, size + radius / 2, position) for centre, size in balls)
            for eye in self._eyes
        ]

    def is_hidden_by_hand(self, position: Floats) -> bool:
        """Return whether a wrist, palm or fingertip is near a line of sight to a position."""
        if self._hands is None and self.posture is not None:
            self._hands = self._kinematics.posed(self.posture, self._place_hands)
        if self._hands is None:
            return False
        return _is_beside(self._hands, self._eyes, position, self._hand_radius)

    def _place_hands(self) -> Floats:
        """Return the points of the hands that may occlude objects, m, shape (k, 3)."""
        return self._kinematics.origins(self._wrists, self._hand_links)

    def hands_have_closed_on(self, position: Floats, radius: float) -> bool:
        """Return whether all fingertips of a hand were inside a ball at the newest images.

        Only an occluded object may be away from its remembered position. The result is therefore
        false if the hands were not placed since the newest images.
        """
        if self._hands is None:
            return False
        return any(
            _are_within(self._hands[fingers], position, share * radius)
            for fingers, share in zip(self._fingers, self._shares, strict=True)
        )


def _is_before(eye: Floats, centre: Floats, radius: float, position: Floats) -> bool:
    """Return whether a ball is between an eye and a position."""
    line, offset = position - eye, centre - eye
    distance = math.sqrt(line.dot(line))
    along = float(offset.dot(line)) / distance
    across = float(offset.dot(offset)) - along * along
    return 0.0 < along < distance and across < radius * radius


@compiled_once
def _are_within(points: Floats, center: Floats, radius: float) -> bool:
    """Return whether all points, shape (n, 3), are within a radius, m, of a center, shape (3,)."""
    for point in points:
        x, y, z = point[0] - center[0], point[1] - center[1], point[2] - center[2]
        if x * x + y * y + z * z >= radius * radius:
            return False
    return True


@compiled_once
def _is_beside(points: Floats, eyes: Floats, position: Floats, radius: float) -> bool:
    """Return whether any point is near the line of sight from any eye to a position.

    Args:
        points: Points that may occlude, m, shape (n, 3).
        eyes: Optical centres of the cameras, m, shape (k, 3).
        position: Position that the eyes look at, m, shape (3,).
        radius: Largest distance of a point from a line of sight, m.
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
