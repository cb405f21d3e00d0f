"""Sensors of a robot with LeRobot's interface, read by the keys of its observations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cbdsl.extend.backend import (
    BackendError,
    Floats,
    Image,
    Joints,
    Kinematics,
    Loads,
    Observation,
    RobotDocument,
)

Values = Mapping[str, Any]

_WRENCH = tuple(f"{kind}.{axis}" for kind in ("force", "torque") for axis in "xyz")


class Sensors:
    """Observations of one robot, from the values that it gives.

    Args:
        name: Name of the robot, for messages.
        document: Robot document.
        kinematics: Kinematics of the robot.
    """

    def __init__(self, name: str, document: RobotDocument, kinematics: Kinematics) -> None:
        self._name, self._document, self._kinematics = name, document, kinematics
        self._joints = Joints(document).names
        self._cells = tuple((h, f) for h, cells in document.load_cells.items() for f in cells)
        self.begin()

    def begin(self) -> None:
        """Forget the observation before."""
        self._next_image, self._before = -np.inf, (np.inf, np.zeros(len(self._joints)))

    def read(self, values: Values, time: float) -> Observation:
        """Return the observation of a time, s, since the beginning of the episode.

        Raises:
            BackendError: A value is missing, not finite, or of the wrong shape.
        """
        positions = self._numbers(values, [f"{joint}.pos" for joint in self._joints])
        velocities = self._velocities(values, positions, time)
        self._before = time, positions
        images = self._images(values, time)
        # The interface has no times of exposure: the document states how late images are.
        exposed = max(0.0, time - self._document.vision.latency) if images else None
        loads = self._loads(values, positions)
        return Observation(time, positions, velocities, loads, images, exposed=exposed)

    def _velocities(self, values: Values, positions: Floats, time: float) -> Floats:
        """Return measured velocities, or differences of positions where none are measured."""
        keys = [f"{joint}.vel" for joint in self._joints]
        if all(key in values for key in keys):
            return self._numbers(values, keys)
        since, before = self._before
        # The first observation has no predecessor: ``since`` is infinite then.
        if time <= since:
            return np.zeros(len(self._joints))
        return (positions - before) / (time - since)

    def _numbers(self, values: Values, keys: Sequence[str]) -> Floats:
        """Return finite numbers by their keys."""
        lacking = [key for key in keys if key not in values]
        if lacking:
            raise BackendError(
                f"{self._name} has no {', '.join(lacking)} in its observation, which has: "
                + ", ".join(map(str, values))
            )
        numbers = np.empty(len(keys))
        for index, key in enumerate(keys):
            try:
                numbers[index] = values[key]
            except (TypeError, ValueError):
                numbers[index] = np.nan
            if not np.isfinite(numbers[index]):
                raise BackendError(f"{self._name} sends {values[key]!r} as {key}: no finite number")
        return numbers

    def _loads(self, values: Values, positions: Floats) -> Loads:
        """Return the wrenches of all load cells in the world's axes."""
        wrenches = np.zeros((len(self._cells), 6))
        if self._cells:
            self._kinematics.update(positions)
        for row, (hand, finger) in enumerate(self._cells):
            own = self._numbers(values, [f"{hand}.{finger}.{axis}" for axis in _WRENCH])
            turn = self._kinematics.frame(self._document.load_cells[hand][finger].link).rotation
            wrenches[row, :3], wrenches[row, 3:] = turn @ own[:3], turn @ own[3:]
        return Loads(self._cells, wrenches)

    def _images(self, values: Values, time: float) -> dict[str, Image]:
        """Return images at the rate of the document, and none in between."""
        if time < self._next_image:
            return {}
        # Half a control period less, so that a tick that is slightly early still has its image.
        self._next_image = time + 1 / self._document.vision.rate - 0.5 / self._document.control.rate
        images = {}
        for name, camera in self._document.cameras.items():
            image, shape = np.asarray(values.get(name)), (camera.height, camera.width, 3)
            if image.shape != shape or image.dtype != np.uint8:
                given = f"{image.dtype} of shape {image.shape}" if name in values else "nothing"
                raise BackendError(
                    f"{self._name} sends {given} as camera '{name}'; "
                    f"robot '{self._document.name}' has bytes (uint8) of shape {shape}"
                )
            images[name] = image.copy()
        return images
