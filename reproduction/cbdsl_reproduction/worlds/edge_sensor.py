"""Kind of sensor ``box_edges``: orientation of a hand that closes on the sides of a seen box.

It uses the regions of both cameras alone; see ``box_fit``. The fingers close along a horizontal
edge of the box: the shorter one if edges differ, or else the edge nearer to their direction now.
Before the object was seen whole, and for a round object, the orientation keeps that direction.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from cbdsl.extend.source import (
    ORIENTATION,
    Reading,
    ResourceType,
    RobotDocument,
    Sensor,
    SensorSignal,
    Signals,
    SourceKind,
)
from cbdsl_reproduction.worlds.box_fit import Floats, fit_box

# Least ratio of horizontal edges that counts as unequal, and least contrast of a box.
_LONG, _EDGED = 1.3, 1.5


def signals_of(sensor: Sensor, robot: RobotDocument) -> Mapping[str, ResourceType]:
    """Return an orientation for each named colour."""
    del sensor, robot
    return dict.fromkeys(("red", "yellow", "green", "blue"), ORIENTATION)


class EdgeReader:
    """Reader of the orientation of a hand that closes on an object.

    Args:
        signal: Signal of the sensor.
        signals: Signals of the robot.
    """

    def __init__(self, signal: SensorSignal, signals: Signals) -> None:
        self._signals, self._channel = signals, signal.part
        robot = signals.robot
        cells = robot.load_cells[robot.sensors[signal.sensor].hand or ""].values()
        self._pads = [cell.link for cell in cells]
        self._arm = _arm_of(signals, next(iter(cells)).joint)
        self._stamp, self._seen = -1, np.zeros(0)
        self._angle: float | None = None
        self._nothing = np.zeros((3, len(signals.joints)))
        signals.vision.look_for([self._channel])

    def __call__(self) -> Reading:
        """Return the orientation in this tick."""
        images = self._signals.vision.images
        if images < self._stamp:
            self._angle, self._seen = None, np.zeros(0)
        if images != self._stamp:
            self._stamp = images
            self._look()
        closing = self._closing()
        angle = math.atan2(closing[1], closing[0]) if self._angle is None else self._angle
        return Reading(self._facing_down(angle), self._nothing, self._signals.clock[0])

    def _look(self) -> None:
        """Fit a box to the object in the newest images if they show all of it."""
        vision, touch = self._signals.vision, self._signals.touch
        memory = vision.memory(self._channel)
        if memory is None or memory.position is None or touch.touching_anything():
            return
        if not memory.is_seen_whole:
            return
        rows, jacobians = [], []
        for name, camera in self._signals.robot.main_cameras.items():
            region, frame = vision.region(name, self._channel), vision.field.frames.get(name)
            if region is None or region.clipped or frame is None:
                return
            scale, (columns, mixed, down) = camera.focal_length**-2, region.moments
            rows.append([region.area * scale, columns * scale, mixed * scale, down * scale])
            jacobians.append(image_jacobian(frame.rotation, memory.position - frame.position))
        silhouettes = np.array(rows)
        # Images of an object at rest before still cameras are equal.
        if not np.array_equal(silhouettes, self._seen):
            self._seen = silhouettes
            self._angle = self._across(np.array(jacobians), silhouettes)

    def _across(self, jacobians: Floats, silhouettes: Floats) -> float | None:
        """Return the direction in which fingers close, rad; ``None`` for a round object."""
        box = fit_box(jacobians, silhouettes)
        if box.contrast < _EDGED:
            return self._angle
        first, second, _ = box.edges.tolist()
        turns = range(4)
        if max(first, second) > _LONG * min(first, second):
            turns = range(0, 4, 2) if first < second else range(1, 4, 2)
        closing = self._closing()
        now = math.atan2(closing[1], closing[0]) if self._angle is None else self._angle
        angles = [box.heading + turn * math.pi / 2 for turn in turns]
        return min(angles, key=lambda angle: 1.0 - math.cos(angle - now))

    def _closing(self) -> Floats:
        """Return the direction from the first pad to the others, world frame, shape (3,)."""
        first, *others = (self._signals.kinematics.frame(pad).position for pad in self._pads)
        direction: Floats = np.mean(others, axis=0) - first
        return direction

    def _facing_down(self, angle: float) -> Floats:
        """Return the orientation of a tip that looks down and closes along an angle, (3, 3)."""
        rotation = self._signals.tips.frame(self._arm).rotation
        x, y, _ = (rotation.T @ self._closing()).tolist()
        # With z down, the tip's x axis is at angle + own, since own angles turn the other way.
        turned = angle + math.atan2(y, x)
        c, s = math.cos(turned), math.sin(turned)
        return np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, -1.0]])


def _arm_of(signals: Signals, joint: str) -> str:
    """Return the effector with a tip that carries a joint."""
    above = signals.kinematics.above(joint)
    robot = signals.robot
    arms = [name for name, each in robot.effectors.items() if each.tip and each.joints]
    return max(arms, key=lambda name: len(above & set(robot.effectors[name].joints)))


def image_jacobian(rotation: Floats, away: Floats) -> Floats:
    """Return the change of image coordinates, to the right and down, at focal length 1, (2, 3).

    Args:
        rotation: Orientation of the camera, which looks along x with z up, shape (3, 3).
        away: Place of the object from the camera, m, world axes, shape (3,).
    """
    x, y, z = (rotation.T @ away).tolist()
    local = np.array([[-y / x, 1.0, 0.0], [-z / x, 0.0, 1.0]]) / -x
    jacobian: Floats = local @ rotation.T
    return jacobian


def reader(signal: SensorSignal, signals: Signals) -> Callable[[], Reading]:
    """Return the reader of a signal."""
    return EdgeReader(signal, signals)


EDGES = SourceKind(
    "box_edges",
    "orientation of a hand that closes on the sides of a seen box, by colour",
    signals_of,
    "cbdsl_reproduction.worlds.edge_sensor:reader",
    needs=("hand",),
)
