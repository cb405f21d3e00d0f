"""Novelty: headings to regions that a channel's background model does not expect (Section 5.2.1).

A background model consists of head postures in which a channel was tracked. A region is novel if
the posture that would track it is far from all of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

import numpy as np

from cbdsl.kinematics.forward import rotation_of
from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.vision.regions.camera import heading, heading_jacobian, sight
from cbdsl.sensing.vision.signals.chosen_headings import ChosenHeadings
from cbdsl.types.resource import NovelHeading

# Distance in standard deviations beyond which the background's density is negligible.
_FAR = 3.0
# Newton steps from anywhere in an image to its middle; after three the error is below 1e-6 rad.
_STEPS = 4


class _WholeRegion(NamedTuple):
    """Region that a camera sees whole.

    Attributes:
        line: Line of sight, world frame, shape (3,).
        posture: Posture of the background's effector that would track the region, rad, shape (n,).
    """

    line: Floats
    posture: Floats


class Novelty(ChosenHeadings[NovelHeading]):
    """Headings to the largest region of a channel that its background model does not expect.

    Regions at an image's border are ignored, because their middles are unknown.
    """

    kind = NovelHeading

    def _choose(self, source: NovelHeading) -> dict[str, Floats]:
        lines: dict[str, Floats] = {}
        first: Floats | None = None
        for camera in self._robot.main_cameras:
            novel = [
                each
                for each in self._whole_regions(camera, source)
                if is_novel(source, each.posture)
            ]
            if not novel:
                continue
            # Both cameras look at the same object.
            chosen = novel[0] if first is None else min(novel, key=partial(_apart, first))
            first = chosen.posture if first is None else first
            lines[camera] = chosen.line
        return lines

    def _whole_regions(self, name: str, source: NovelHeading) -> Iterator[_WholeRegion]:
        """Yield regions of a channel that a camera sees whole, the largest first."""
        camera = self._robot.cameras[name]
        regions = self._vision.seen.get(name, {}).get(source.channel, ())
        if not regions:
            return
        # The head may have turned since the image was taken.
        frame = self._vision.field.frames[name]
        turned = self._kinematics.frame(camera.link).rotation.T.dot(frame.rotation)
        for region in regions:
            if not region.clipped:
                line = sight(camera, region.column, region.row)
                posture = self._tracking(source.effector, camera.link, turned.dot(line))
                yield _WholeRegion(frame.rotation.dot(line), posture)

    def _tracking(self, effector: str, link: str, line: Floats) -> Floats:
        """Return the posture that centres a line of sight, in the camera's axes, in the image."""
        kinematics, columns = self._kinematics, self._kinematics.joints.of(effector)
        posture: Floats = kinematics.positions[columns].copy()
        # Joints that move the camera, from the root outwards.
        moving = kinematics.tree["column"][kinematics.link(link).support].tolist()
        own = columns.tolist()
        places = [own.index(column) for column in dict.fromkeys(moving) if column in own]
        axes = kinematics.own_turning(link)[:, columns[places]]
        posture[places] += centring(axes, line)
        return posture


def centring(axes: Floats, line: Floats) -> Floats:
    """Return the joint displacements that bring a line of sight to the middle of the image.

    Args:
        axes: Unit axes of the joints from the root outwards, in the camera's axes, shape (3, n).
        line: Line of sight in the camera's axes, shape (3,).

    Returns:
        Joint displacements, rad, shape (n,).
    """
    turns = np.zeros(axes.shape[1])
    for _ in range(_STEPS):
        after, columns = np.eye(3), np.empty_like(axes)
        for joint in reversed(range(len(turns))):
            columns[:, joint] = after.T.dot(axes[:, joint])
            after = rotation_of(axes[:, joint] * turns[joint]).dot(after)
        angles = heading(after.T.dot(line))
        turns -= np.linalg.pinv(heading_jacobian(angles).dot(columns)).dot(angles)
    return turns


def is_novel(source: NovelHeading, posture: Floats) -> bool:
    """Return whether the background's density at a posture is negligible.

    Args:
        source: Heading source with the background's density.
        posture: Joint positions, rad, shape (n,).
    """
    centres, spread = np.array(source.expected.centres), np.array(source.expected.spread)
    squares = (((posture - centres) / spread) ** 2).sum(axis=1)
    return bool(squares.min() > _FAR**2)


def _apart(posture: Floats, seen: _WholeRegion) -> float:
    return float(np.linalg.norm(seen.posture - posture))
