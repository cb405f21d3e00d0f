"""Lines of sight to regions that were chosen in images, kept for as long as these are seen."""

from __future__ import annotations

from collections.abc import Hashable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import RobotDocument
from cbdsl.sensing.camera import heading, heading_jacobian
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.sensing.reading import Reading, mean

Floats = NDArray[np.float64]


class _Kept(NamedTuple):
    """Lines of sight, by camera, the number of the images that show them, and their time, s."""

    lines: dict[str, Floats]
    image: int
    time: float


class KeptSights:
    """Lines of sight by what they lead to, and headings along them.

    What was seen a moment ago still is, see ``Vision``. It stands still while the cameras move.

    Args:
        robot: whose cameras look.
        kinematics: of the same robot.
    """

    def __init__(self, robot: RobotDocument, kinematics: Kinematics) -> None:
        self._cameras, self._kinematics = robot.cameras, kinematics
        self._linger = robot.vision.regions.linger
        self.reset()

    def reset(self) -> None:
        """Forget the episode before."""
        self._kept: dict[Hashable, _Kept] = {}

    def renew(self, key: Hashable, lines: dict[str, Floats], image: int, time: float) -> None:
        """Take in what the newest images show.

        Args:
            key: what is looked for.
            lines: of sight to it, world frame, shape (3,), by camera; none where it is not seen.
            image: number of the images.
            time: s.
        """
        if lines:
            self._kept[key] = _Kept(lines, image, time)
        elif key in self._kept and time - self._kept[key].time > self._linger:
            del self._kept[key]

    def heading(self, key: Hashable) -> Reading | None:
        """The mean heading over the cameras that see it, ``None`` while none does."""
        kept = self._kept.get(key)
        if kept is None:
            return None
        return mean([self._reading(name, line, kept.image) for name, line in kept.lines.items()])

    def _reading(self, camera: str, line: Floats, image: int) -> Reading:
        """The heading to a line of sight, as the cameras move it."""
        link = self._cameras[camera].link
        angles = heading(self._kinematics.frame(link).rotation.T.dot(line))
        jacobian = heading_jacobian(angles).dot(self._kinematics.own_turning(link))
        return Reading(angles, jacobian, image)
