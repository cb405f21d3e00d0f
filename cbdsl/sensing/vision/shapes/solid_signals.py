"""Signals of the sizes of objects, and of places and orientations that follow from them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.kinematics.turned_posture import start_place
from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.table.reading import Reading
from cbdsl.sensing.touch.touch import Touch
from cbdsl.sensing.vision.shapes.solid import Silhouette, Solid
from cbdsl.sensing.vision.vision import Vision
from cbdsl.types.resource import Resource, SolidSignal
from cbdsl.types.source_record import sources_of


class SolidSignals:
    """Reader of the sizes of objects, which are measured while no hand touches anything.

    Args:
        robot: Robot document with a stereo pair.
        kinematics: Kinematics of the same robot.
        vision: Regions and memories of the cameras.
        touch: Contacts of the hands.
    """

    def __init__(
        self, robot: RobotDocument, kinematics: Kinematics, vision: Vision, touch: Touch
    ) -> None:
        self._robot, self._vision, self._touch = robot, vision, touch
        self._kinematics = kinematics
        self._solids: dict[tuple[str, str], Solid] = {}
        self._starts: dict[str, Floats] = {}

    def follow(self, resources: Iterable[Resource]) -> None:
        """Follow the sizes of more resources from now on."""
        for source in sources_of(resources, SolidSignal):
            self._solids.setdefault(source.pair, Solid())
            name = source.effector
            if name and name not in self._starts:
                self._starts[name] = start_place(self._robot, self._kinematics, name)

    def reset(self) -> None:
        """Forget the previous episode."""
        for solid in self._solids.values():
            solid.reset()

    def update(self, observation: Observation) -> None:
        """Update the sizes from the newest images; vision must be up to date."""
        if not (observation.images or observation.regions) or self._touch.touching_anything():
            return
        for (channel, other), solid in self._solids.items():
            self._see(solid, channel, other)

    def _see(self, solid: Solid, channel: str, other: str) -> None:
        memory, support = self._vision.memory(channel), self._vision.memory(other)
        if memory is None or memory.position is None or not memory.is_seen_whole:
            return
        if support is None or support.position is None:
            return
        silhouettes = self._silhouettes(channel)
        if len(silhouettes) == len(self._robot.main_cameras):
            solid.see(memory.position, float(support.position[2]), silhouettes)

    def _silhouettes(self, channel: str) -> list[Silhouette]:
        """Return the whole regions of a channel's object in the newest images."""
        silhouettes, frames = [], self._vision.field.frames
        for name, camera in self._robot.main_cameras.items():
            region = self._vision.region(name, channel)
            if region is not None and not region.clipped and name in frames:
                silhouettes.append(Silhouette(camera, frames[name], region))
        return silhouettes

    def read(self, source: SolidSignal) -> Reading | None:
        """Return a part of an object's size, or ``None`` before it was seen whole."""
        solid, memory = self._solids[source.pair], self._vision.memory(source.channel)
        if not solid.is_known or memory is None or memory.position is None:
            return None
        if source.part == "placed":
            return self._placed(solid, source.other)
        if source.part == "beside":
            value = solid.facing_aside(memory.position, self._starts[source.effector])
        else:
            value = self._value(source.part, solid, memory.position)
        return Reading(value, None, self._vision.images)

    def _placed(self, solid: Solid, other: str) -> Reading | None:
        """Return the place of an object's centre when it stands on the other object, m."""
        support = self._vision.memory(other)
        if support is None or support.position is None:
            return None
        centre = support.position + np.array([0.0, 0.0, solid.rise])
        return Reading(centre, None, self._vision.images)

    def _value(self, part: str, solid: Solid, centre: Floats) -> Floats:
        if part == "top":
            return np.array([*centre[:2].tolist(), solid.top])
        if part == "above":
            return solid.facing_down(centre)
        along, across = solid.extents
        sizes = {"length": along, "width": across, "height": solid.height, "bulk": solid.bulk}
        return np.array([sizes[part]])
