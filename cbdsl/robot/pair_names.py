"""Names of signals of two channels: ``left.red.to.blue`` compares red with blue.

``stereo.red.on.green.width`` is the width of the red object, on the level of the green one, and
``stereo.red.on.green.beside.right_arm`` an orientation of that arm beside it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from cbdsl.robot.resources import APPROACH_PARTS, SOLID_PARTS, STEREO
from cbdsl.types.resource import (
    CYCLOPEAN,
    ConstellationSignal,
    Origin,
    Resource,
    SolidSignal,
    StereoOffset,
)
from cbdsl.types.resource_type import CONSTELLATION, OFFSET
from cbdsl.types.source_record import camera_of, channel_of, is_located, is_tip

#: Word between the two channels.
_TO, _ON = "to", "on"


class PairName(NamedTuple):
    """Pair of signals of the same kind, whose channels are compared.

    Attributes:
        first: Heading or position of the compared channel.
        second: Heading or position of the channel of comparison.
        part: Part of the first object's size, on the level of the second object; empty otherwise.
        effector: Effector whose tip the part is of; empty otherwise.
    """

    first: Resource
    second: Resource
    part: str = ""
    effector: str = ""

    @property
    def is_of_one(self) -> bool:
        """Whether a channel is compared with itself, possibly under another name."""
        return self.first.source == self.second.source

    def resource(self, name: str) -> Resource:
        """Return the signal of both channels, by its whole name."""
        first, second = channel_of(self.first.source), channel_of(self.second.source)
        if self.part:
            size = SolidSignal(first, second, self.part, self.effector)
            kind = (APPROACH_PARTS if self.effector else SOLID_PARTS)[self.part]
            return Resource(name, kind, Origin.TRIANGULATION, size)
        if is_located(self.first.source):
            offset = StereoOffset(first, second)
            return Resource(name, OFFSET, Origin.TRIANGULATION, offset)
        seen = ConstellationSignal(camera_of(self.first), first, second)
        return Resource(name, CONSTELLATION, Origin.ENVIRONMENT, seen)


def parse_pair(name: str, named: Mapping[str, Resource]) -> PairName | None:
    """Return the parts of a name such as ``left.red.to.blue``, or ``None`` for other names.

    Args:
        name: Name of a resource.
        named: Resources of the robot by name.
    """
    parts = name.split(".")
    if not (len(parts) == 4 and parts[2] == _TO) and not _is_size(parts, named):
        return None
    first, second = named.get(f"{parts[0]}.{parts[1]}"), named.get(f"{parts[0]}.{parts[3]}")
    if first is None or second is None or not (_has_blobs(first) and _has_blobs(second)):
        return None
    return PairName(first, second, *parts[4:])


def pair_resource(name: str, named: Mapping[str, Resource]) -> Resource | None:
    """Return the signal of two channels that a name stands for, or ``None``."""
    pair = parse_pair(name, named)
    return None if pair is None or pair.is_of_one else pair.resource(name)


def pair_features(
    feature: str, goal: str, camera: str, named: Mapping[str, Resource]
) -> dict[str, Resource]:
    """Return the constellation of two objects in a camera, and the offset between them.

    Args:
        feature: Channel of the first object.
        goal: Channel of the second object.
        camera: Name of the camera.
        named: Resources of the robot by name.
    """
    ends = f"{feature}.{_TO}.{goal}"
    names = {"constellation": f"{camera}.{ends}", "offset": f"{STEREO}.{ends}"}
    signals = {key: pair_resource(name, named) for key, name in names.items()}
    return {key: each for key, each in signals.items() if each is not None}


def _is_size(parts: Sequence[str], named: Mapping[str, Resource]) -> bool:
    """Return whether the parts of a name are those of an object's size on a level."""
    if parts[0] != STEREO or parts[2:3] != [_ON]:
        return False
    if len(parts) == 6:
        tip = named.get(f"{parts[5]}.orientation")
        return parts[4] in APPROACH_PARTS and tip is not None and is_tip(tip.source)
    return len(parts) == 5 and parts[4] in SOLID_PARTS


def _has_blobs(resource: Resource) -> bool:
    return camera_of(resource) not in ("", CYCLOPEAN) or is_located(resource.source)
