"""Views of what a hand holds, gathered while a program shows it to the cameras."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import RobotDocument
from cbdsl.runtime.episode import Tick
from cbdsl.sensing.kinematics import Kinematics

Floats = NDArray[np.float64]

#: Fingertips from which a ball's centre follows.
FINGERS = 3
# Where joints move faster, images and joint positions need not be of the same instant, rad/s.
_SLOW = 0.15
# Views that differ by less in every joint tell nothing new, rad.
_APART = 0.02


class HandView(NamedTuple):
    """HandView of a held ball by one camera.

    Attributes:
        camera: its name.
        position, rotation: of the camera as the model has it, world frame, m, shapes (3,), (3, 3).
        point: centroid of the ball's region, column and row, px, shape (2,).
        area: of the region, px.
        tips: centres of the fingertips that touch the ball, world frame, m, shape (3, 3).
        forces: by these fingertips on the ball, world frame, N, shape (3, 3).
        hold: number of the hold in which it was seen: a ball that is taken anew lies otherwise.
    """

    camera: str
    position: Floats
    rotation: Floats
    point: Floats
    area: float
    tips: Floats
    forces: Floats
    hold: int = 0


class ViewRecorder:
    """Records views of what a hand holds, in episodes of a program.

    It reads joint positions, load cells and image regions, nothing else.

    Args:
        robot: whose cameras look.
        kinematics: of the same robot, without corrections.
        hand: which holds the ball with at least three fingers.
        channel: in which the ball is seen.
        hold: number of the hold.

    Attributes:
        views: all that were recorded.
        touched: whether all fingers have felt something.
        seen: images in which each camera saw the ball at all.
    """

    def __init__(
        self, robot: RobotDocument, kinematics: Kinematics, hand: str, channel: str, hold: int = 0
    ) -> None:
        self._robot, self._kinematics = robot, kinematics
        self._channel, self._hold = channel, hold
        cells = robot.load_cells[hand]
        self._hand, self._links = hand, [cell.link for cell in cells.values()][:FINGERS]
        self.views: list[HandView] = []
        self.touched = False
        self.seen = dict.fromkeys(robot.cameras, 0)
        self._last: Mapping[str, Floats] = {}

    def note(self, tick: Tick) -> None:
        """Take in a control tick."""
        observation, touch = tick.observation, tick.signals.touch
        if not (observation.images or observation.regions) or not touch.all_touching(self._hand):
            return
        self.touched = True
        slow = bool(np.abs(observation.velocities).max() <= _SLOW)
        for camera in self._robot.cameras:
            region = tick.signals.vision.region(camera, self._channel)
            if region is None:
                continue
            self.seen[camera] += 1
            if slow and not region.clipped and self._is_new(camera, observation.positions):
                first, _ = touch.span(self._hand)
                forces = touch.loads[first : first + FINGERS, :3].copy()
                posture = tick.signals.vision.field.posture
                assert posture is not None
                with self._kinematics.posed(posture):
                    self._record(camera, np.array((region.column, region.row)), region.area, forces)

    def _is_new(self, camera: str, positions: Floats) -> bool:
        """Whether the robot has another posture than in the camera's last view."""
        before = self._last.get(camera)
        if before is not None and np.abs(positions - before).max() < _APART:
            return False
        self._last = {**self._last, camera: positions.copy()}
        return True

    def _record(self, camera: str, point: Floats, area: float, forces: Floats) -> None:
        frame = self._kinematics.frame(self._robot.cameras[camera].link)
        tips = np.array([self._kinematics.frame(link).position for link in self._links])
        self.views.append(HandView(camera, *frame, point, area, tips, forces, self._hold))
