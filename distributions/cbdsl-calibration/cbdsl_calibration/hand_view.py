"""Views of a held ball, gathered while a program shows it to the cameras."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import NamedTuple

import numpy as np

from cbdsl.api.sensing import Tick
from cbdsl.extend.backend import Floats, Kinematics, RobotDocument

#: Number of fingertips that determine a ball's centre.
FINGERS = 3
# Joint speed above which images and joint positions may be of different instants, rad/s.
_SLOW = 0.15
# Smallest difference in a joint position between two useful views, rad.
_APART = 0.02


class HandView(NamedTuple):
    """View of a held ball by one camera.

    Attributes:
        camera: Name of the camera.
        position, rotation: Pose of the camera by the model, world frame, m, shapes (3,), (3, 3).
        point: Centroid of the ball's region, column and row, px, shape (2,).
        area: Area of the region, px.
        tips: Centres of the fingertips that touch the ball, world frame, m, shape (3, 3).
        hold: Number of the hold; in another hold the ball lies in another way.
    """

    camera: str
    position: Floats
    rotation: Floats
    point: Floats
    area: float
    tips: Floats
    hold: int = 0


class ViewRecorder:
    """Recorder of views of a held ball, in episodes of a program.

    It reads only joint positions, load cells and image regions.

    Args:
        robot: Robot with the cameras.
        kinematics: Kinematics of the same robot, without corrections.
        hand: Hand that holds the ball with at least three fingers.
        channel: Channel of the ball.
        hold: Number of the hold.

    Attributes:
        views: All recorded views.
        touched: True if all fingers have measured contact.
        seen: Number of images in which each camera saw the ball.
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
        """Process a control tick."""
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
                posture = tick.signals.vision.field.posture
                assert posture is not None
                point = np.array((region.column, region.row))
                record = partial(self._record, camera, point, region.area)
                self._kinematics.posed(posture, record)

    def _is_new(self, camera: str, positions: Floats) -> bool:
        """Return whether the posture differs from that of the camera's last view, and note it."""
        before = self._last.get(camera)
        if before is not None and np.abs(positions - before).max() < _APART:
            return False
        self._last = {**self._last, camera: positions.copy()}
        return True

    def _record(self, camera: str, point: Floats, area: float) -> None:
        frame = self._kinematics.frame(self._robot.cameras[camera].link)
        tips = np.array([self._kinematics.frame(link).position for link in self._links])
        self.views.append(HandView(camera, *frame, point, area, tips, self._hold))
