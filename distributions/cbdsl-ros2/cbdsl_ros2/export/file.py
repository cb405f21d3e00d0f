"""Recorded episodes as MCAP files of ROS 2 messages, as ``ros2 bag`` writes them.

Times are simulated, from 0. Topics:

- ``/joint_states`` and ``/joint_references`` (sensor_msgs/JointState);
- ``/tf`` and ``/tf_static`` (tf2_msgs/TFMessage) of the links, the cameras and the objects;
- ``/camera/NAME/image_raw`` (sensor_msgs/Image) and ``/camera/NAME/camera_info``
  (sensor_msgs/CameraInfo);
- ``/wrench/HAND/FINGER`` (geometry_msgs/WrenchStamped), in the axes of the load cell's link;
- ``/potentials/NAME`` (std_msgs/Float64) and ``/predicates/NAME`` (std_msgs/String);
- ``/objects`` (visualization_msgs/MarkerArray), ``/rosout`` (rcl_interfaces/Log) with the
  transitions, and ``/robot_description`` (std_msgs/String) with the URDF.

Needs the extra ``mcap``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cbdsl.extend.export import DrawnLink, Recorded, inverse, read_links, replace_file, turned
from cbdsl_ros2.export.bag import Bag
from cbdsl_ros2.export.markers import markers
from cbdsl_ros2.export.ros_messages import TYPES, header, make, stamp, vector
from cbdsl_ros2.export.transforms import (
    UNTURNED,
    WORLD,
    fixed_frames,
    moving_frames,
    optical_frame,
    world_turns,
)

Stamped = tuple[float, str, Any]
_LOG: Any = TYPES.types["rcl_interfaces/msg/Log"]


def write_ros2_mcap(recorded: Recorded, target: Path) -> int:
    """Write a recording and return the number of messages.

    Raises:
        OSError: The file cannot be written.
    """
    bag, summary = Bag(), recorded.summary
    robot = summary["robot"]
    links = read_links(robot, summary["joints"])
    bag.put_metadata("result", {key: str(value) for key, value in summary["result"].items()})
    description = make("std_msgs/String", data=robot["urdf"])
    bag.put("/robot_description", 0.0, description, latched=True)
    bag.put("/tf_static", 0.0, fixed_frames(links, robot.get("cameras", {})), latched=True)
    bag.put("/objects", 0.0, markers(summary["scene"]), latched=True)
    # The sort is stable: messages of one tick keep their order.
    for time, topic, message in sorted(_messages(recorded, links), key=lambda row: row[0]):
        bag.put(topic, time, message)
    content = bag.finish()
    replace_file(target, lambda file: file.write(content), follow=True)
    return bag.count


def _messages(recorded: Recorded, links: Sequence[DrawnLink]) -> Iterator[Stamped]:
    """Yield all that changes, with times, s, and topics, in any order."""
    for tick, time in enumerate(recorded.arrays["time"].tolist()):
        yield time, "/tf", moving_frames(recorded, links, tick, time)
        yield from _joints(recorded, tick, time)
        yield from _wrenches(recorded, links, tick, time)
        yield from _controllers(recorded, tick, time)
    yield from _images(recorded)
    yield from _transitions(recorded)


def _joints(recorded: Recorded, tick: int, time: float) -> Iterator[Stamped]:
    """Yield the measured and the commanded positions of the actuated joints."""
    arrays, names, nothing = recorded.arrays, list(recorded.summary["joints"]), np.zeros(0)
    # Recordings of earlier versions have no velocities; a state may leave them out.
    velocities = arrays["velocities"][tick] if "velocities" in arrays else nothing
    state = (arrays["positions"][tick], velocities)
    for topic, (positions, speeds) in {
        "/joint_states": state,
        "/joint_references": (arrays["references"][tick], nothing),
    }.items():
        yield time, topic, make(
            "sensor_msgs/JointState", header=header(time, ""), name=names,
            position=positions, velocity=speeds, effort=nothing,
        )  # fmt: skip


def _wrenches(
    recorded: Recorded, links: Sequence[DrawnLink], tick: int, time: float
) -> Iterator[Stamped]:
    """Yield the wrenches that the load cells exert, each in the axes of its link."""
    cells = recorded.summary["robot"].get("cells", {})
    turns = world_turns(links, recorded.arrays["positions"][tick]) if cells else {}
    names = recorded.summary["load_cells"]
    for name, load in zip(names, recorded.arrays["loads"][tick], strict=True):
        # Recordings of earlier versions do not name the cells' links.
        frame = cells.get(name, WORLD)
        # Loads are recorded in the axes of the world, and a stamped wrench is in those of its
        # frame.
        back = inverse(turns.get(frame, UNTURNED))
        wrench = make(
            "geometry_msgs/Wrench",
            force=vector(turned(back, load[:3])),
            torque=vector(turned(back, load[3:])),
        )
        message = make("geometry_msgs/WrenchStamped", header=header(time, frame), wrench=wrench)
        yield time, f"/wrench/{_topic(name)}", message


def _topic(name: str) -> str:
    """Return a dotted name as part of a topic, which has only letters, digits, ``_`` and ``/``."""
    return re.sub(r"[^A-Za-z0-9_/]+", "_", name.replace(".", "/")).strip("_")


def _controllers(recorded: Recorded, tick: int, time: float) -> Iterator[Stamped]:
    """Yield the potentials that are defined, and the predicates."""
    letters = recorded.summary["predicates"][tick]
    potentials = recorded.arrays["potentials"][tick].tolist()
    for name, letter, phi in zip(recorded.controllers, letters, potentials, strict=True):
        yield time, f"/predicates/{_topic(name)}", make("std_msgs/String", data=letter)
        if not math.isnan(phi):
            yield time, f"/potentials/{_topic(name)}", make("std_msgs/Float64", data=phi)


def _images(recorded: Recorded) -> Iterator[Stamped]:
    """Yield the images, each with the intrinsics of its camera where they were recorded."""
    cameras = recorded.summary["robot"].get("cameras", {})
    times = recorded.arrays["image_time"].tolist()
    for name, images in recorded.images.items():
        for time, image in zip(times, images, strict=True):
            height, width = image.shape[:2]
            head = header(time, optical_frame(name))
            yield time, f"/camera/{name}/image_raw", make(
                "sensor_msgs/Image", header=head, height=height, width=width, encoding="rgb8",
                is_bigendian=0, step=3 * width, data=np.ascontiguousarray(image).ravel(),
            )  # fmt: skip
            if name in cameras:
                info = _camera_info(head, cameras[name], width, height)
                yield time, f"/camera/{name}/camera_info", info


def _camera_info(head: Any, camera: Mapping[str, Any], width: int, height: int) -> Any:
    """Return the intrinsics of a pinhole without distortion, at the size of the recorded image."""
    across = camera["focal_length"] * width / camera["width"]
    down = camera["focal_length"] * height / camera["height"]
    # Pixel centres are whole numbers in ROS, so that the image's centre is half a pixel less.
    x, y = width / 2 - 0.5, height / 2 - 0.5
    return make(
        "sensor_msgs/CameraInfo", header=head, height=height, width=width,
        distortion_model="plumb_bob", d=np.zeros(5),
        k=np.array([across, 0.0, x, 0.0, down, y, 0.0, 0.0, 1.0]), r=np.eye(3).ravel(),
        p=np.array([across, 0.0, x, 0.0, 0.0, down, y, 0.0, 0.0, 0.0, 1.0, 0.0]),
        binning_x=0, binning_y=0,
        roi=make("sensor_msgs/RegionOfInterest", x_offset=0, y_offset=0, height=0, width=0,
                  do_rectify=False),
    )  # fmt: skip


def _transitions(recorded: Recorded) -> Iterator[Stamped]:
    """Yield the transitions and the ending as lines of a log."""
    result, times = recorded.summary["result"], recorded.arrays["time"]
    lines = [(row["time"], row["program"], _line(row)) for row in recorded.transitions]
    end = float(times[-1]) if len(times) else 0.0
    for time, program, text in [*lines, (end, result["program"], result["ending"])]:
        yield time, "/rosout", make(
            "rcl_interfaces/Log", stamp=stamp(time), level=_LOG.INFO, name=program, msg=text,
            file="", function="", line=0,
        )  # fmt: skip


def _line(row: Mapping[str, Any]) -> str:
    reward = f"  reward {row['reward']}" if row["reward"] else ""
    return f"{row['state']} -> {row['next_state']}  {row['words'] or row['action']}{reward}"
