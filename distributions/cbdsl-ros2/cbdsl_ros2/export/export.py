"""Export ``ros2``: recorded episodes as MCAP files of ROS 2 messages."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from cbdsl.extend.export import Export

if TYPE_CHECKING:
    from cbdsl.extend.export import Recorded


def write(recordings: Iterable[Recorded], target: Path) -> str:
    """Write recorded episodes as MCAP with messages of ROS 2 in CDR.

    The messages are those of sensor_msgs, geometry_msgs, tf2_msgs and others, by simulated time:
    joint states, transforms, objects, images, camera intrinsics, wrenches, potentials, predicates
    and transitions. Readers need no installation of ROS.
    """
    from cbdsl_ros2.export.file import write_ros2_mcap

    (recorded,) = recordings
    messages = write_ros2_mcap(recorded, target)
    return f"{messages} messages, {target.stat().st_size / 1e6:.1f} MB"


ROS2 = Export(write, suffix=".mcap")
