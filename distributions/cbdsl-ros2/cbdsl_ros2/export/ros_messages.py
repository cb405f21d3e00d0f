"""ROS 2 messages by the names of their types."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rosbags.typesys import Stores, get_typestore

from cbdsl.extend.export import Floats

#: Definitions of the types. The types of these modules are the same in later distributions.
TYPES = get_typestore(Stores.ROS2_HUMBLE)
#: Nanoseconds of a second.
NANO = 1_000_000_000


def make(name: str, /, **fields: Any) -> Any:
    """Return a message of the type ``package/Name``."""
    package, _, kind = name.partition("/")
    return TYPES.types[f"{package}/msg/{kind}"](**fields)


def stamp(time: float) -> Any:
    """Return a time, s, as a message."""
    seconds, nanoseconds = divmod(round(time * NANO), NANO)
    return make("builtin_interfaces/Time", sec=seconds, nanosec=nanoseconds)


def header(time: float, frame: str) -> Any:
    """Return the head of a message of a time, s, and a frame."""
    return make("std_msgs/Header", stamp=stamp(time), frame_id=frame)


def vector(values: Sequence[float] | Floats, kind: str = "Vector3") -> Any:
    """Return three numbers as a ``Vector3`` or a ``Point``."""
    return make(f"geometry_msgs/{kind}", **dict(zip("xyz", map(float, values), strict=True)))


def quaternion(values: Sequence[float] | Floats) -> Any:
    """Return four numbers (x, y, z, w) as a quaternion."""
    return make("geometry_msgs/Quaternion", **dict(zip("xyzw", map(float, values), strict=True)))
