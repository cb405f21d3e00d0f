"""Markers of the objects of a recorded episode, each in the frame of its object."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cbdsl_ros2.export.ros_messages import TYPES, header, make, quaternion, vector
from cbdsl_ros2.export.transforms import object_frame

_MARKER: Any = TYPES.types["visualization_msgs/msg/Marker"]
_NO_DATA = np.zeros(0, dtype=np.uint8)
_KINDS = {
    "box": _MARKER.CUBE,
    "ball": _MARKER.SPHERE,
    "cylinder": _MARKER.CYLINDER,
    "mesh": _MARKER.TRIANGLE_LIST,
}


def markers(scene: Mapping[str, Sequence[Mapping[str, Any]]]) -> Any:
    """Return the shapes of all objects, by name, as one message."""
    shapes = [
        _marker(name, index, part)
        for name, parts in scene.items()
        for index, part in enumerate(parts)
    ]
    return make("visualization_msgs/MarkerArray", markers=shapes)


def _marker(name: str, index: int, part: Mapping[str, Any]) -> Any:
    pose = make(
        "geometry_msgs/Pose",
        position=vector(part["position"], "Point"),
        orientation=quaternion(part["quaternion"]),
    )
    red, green, blue = map(float, part["color"])
    texture = make("sensor_msgs/CompressedImage", header=header(0.0, ""), format="", data=_NO_DATA)
    return make(
        "visualization_msgs/Marker", header=header(0.0, object_frame(name)), ns=name, id=index,
        type=_KINDS[part["shape"]], action=_MARKER.ADD, pose=pose, scale=vector(_edges(part)),
        color=make("std_msgs/ColorRGBA", r=red, g=green, b=blue, a=1.0),
        lifetime=make("builtin_interfaces/Duration", sec=0, nanosec=0), frame_locked=True,
        points=_corners(part), colors=[], texture_resource="", texture=texture,
        uv_coordinates=[], text="", mesh_resource="",
        mesh_file=make("visualization_msgs/MeshFile", filename="", data=_NO_DATA),
        mesh_use_embedded_materials=False,
    )  # fmt: skip


def _edges(part: Mapping[str, Any]) -> Sequence[float]:
    """Return the lengths of a part along its axes, m; 1 for a mesh, whose corners are in m."""
    size = part["size"]
    if part["shape"] == "mesh":
        return (1.0, 1.0, 1.0)
    if part["shape"] == "box":
        return tuple(size)
    width = 2 * size[0]
    return (width, width, width if part["shape"] == "ball" else size[1])


def _corners(part: Mapping[str, Any]) -> list[Any]:
    """Return three points for each triangle of a mesh, and none for other parts."""
    if part["shape"] != "mesh":
        return []
    # Lists of triangles have no indices, so that shared corners are repeated.
    mesh = part["mesh"]
    points = [vector(corner, "Point") for corner in mesh["corners"]]
    return [points[index] for triangle in mesh["triangles"] for index in triangle]
