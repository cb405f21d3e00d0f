"""Transforms of a recorded episode: links, optical frames of the cameras, and objects."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cbdsl.extend.export import DrawnLink, Floats, Recorded, placed, product, quaternion_about
from cbdsl_ros2.export.ros_messages import header, make, quaternion, vector

#: Root of all frames.
WORLD = "world"
#: Quaternion of no rotation.
UNTURNED = np.array([0.0, 0.0, 0.0, 1.0])
# Axes of an optical frame (x right, y down, z forward) in a camera's (x forward, y left, z up).
_OPTICAL = np.array([-0.5, 0.5, -0.5, 0.5])


def fixed_frames(links: Sequence[DrawnLink], cameras: Mapping[str, Any]) -> Any:
    """Return the transforms of links that no joint moves, and of the cameras' optical frames."""
    frames = [_link_frame(links, link, np.zeros(0), 0.0) for link in links if link.column < 0]
    for name, camera in cameras.items():
        place, turn, correction = np.zeros(3), UNTURNED, camera.get("correction")
        if correction is not None:
            place, turn = np.array(correction["position"]), _rotation(correction["rotation"])
        turn = product(turn, _OPTICAL)
        frames.append(_frame(0.0, camera["link"], optical_frame(name), place, turn))
    return make("tf2_msgs/TFMessage", transforms=frames)


def moving_frames(recorded: Recorded, links: Sequence[DrawnLink], tick: int, time: float) -> Any:
    """Return the transforms of links that joints move, and of the objects in the world."""
    positions = recorded.arrays["positions"][tick]
    frames = [_link_frame(links, link, positions, time) for link in links if link.column >= 0]
    scene = recorded.arrays["scene"]
    if len(scene):
        for name, pose in zip(recorded.summary["scene"], scene[tick], strict=True):
            if not math.isnan(pose[0]):
                frames.append(_frame(time, WORLD, object_frame(name), pose[:3], pose[3:]))
    return make("tf2_msgs/TFMessage", transforms=frames)


def world_turns(links: Sequence[DrawnLink], positions: Floats) -> dict[str, Floats]:
    """Return the orientation of each link in the world as a quaternion, by name."""
    turns: list[Floats] = []
    for link in links:
        # Parents precede their children, so that the turn of the parent is known.
        _, turn = placed(link, positions)
        turns.append(turn if link.parent < 0 else product(turns[link.parent], turn))
    return {link.name: turn for link, turn in zip(links, turns, strict=True)}


def optical_frame(camera: str) -> str:
    """Return the name of a camera's optical frame."""
    return f"{camera}_optical_frame"


def object_frame(name: str) -> str:
    """Return the name of an object's frame."""
    return f"object/{name}"


def _link_frame(links: Sequence[DrawnLink], link: DrawnLink, positions: Floats, time: float) -> Any:
    parent = WORLD if link.parent < 0 else links[link.parent].name
    return _frame(time, parent, link.name, *placed(link, positions))


def _frame(time: float, parent: str, child: str, place: Floats, turn: Floats) -> Any:
    transform = make(
        "geometry_msgs/Transform", translation=vector(place), rotation=quaternion(turn)
    )
    head = header(time, parent)
    return make(
        "geometry_msgs/TransformStamped", header=head, child_frame_id=child, transform=transform
    )


def _rotation(rotation: Sequence[float]) -> Floats:
    """Return the quaternion of a rotation vector, rad, shape (3,)."""
    angle = math.hypot(*rotation)
    axis = np.array(rotation) / (angle or 1.0)
    return quaternion_about(axis, angle)
