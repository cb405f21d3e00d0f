"""MCAP files of recorded episodes, with the schemas of Foxglove if they exist.

All topics use simulated time and SI units. ``/tf`` (foxglove.FrameTransforms) has the frames of
all links and objects. ``/robot`` and ``/things`` (foxglove.SceneUpdate) have their shapes, and
``/camera/NAME`` (foxglove.CompressedImage) has the images. Further topics are ``/joint_states``,
``/potentials``, ``/predicates``, ``/signals`` and ``/transitions`` (foxglove.Log). The robot's URDF
is an attachment.

Needs the extra ``mcap``.
"""

from __future__ import annotations

import base64
import io
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from mcap.writer import Writer

from cbdsl.extend.export import (
    DrawnLink,
    Floats,
    Recorded,
    placed,
    read_links,
    replace_file,
    title_of,
)
from cbdsl_mcap.mcap_schemas import SCHEMAS

Json = dict[str, Any]

#: Root of all frames.
WORLD = "world"
_NANO = 1_000_000_000
_INFO = 2


def write_mcap(recorded: Recorded, target: Path) -> int:
    """Write a recording, and return the number of messages.

    Raises:
        OSError: The file cannot be written.
    """
    # The file is complete in memory before it replaces another one.
    stream = io.BytesIO()
    messages = _Messages(Writer(stream), recorded)
    count = messages.write()
    replace_file(target, lambda file: file.write(stream.getvalue()), follow=True)
    return count


class _Messages:
    """Messages of one episode."""

    def __init__(self, writer: Writer, recorded: Recorded) -> None:
        self._writer, self._recorded = writer, recorded
        self._summary, self._arrays = recorded.summary, recorded.arrays
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._count = 0

    def write(self) -> int:
        """Write all messages, and return their number."""
        result = self._summary["result"]
        self._writer.start(profile="", library="cbdsl")
        self._writer.add_metadata("result", {key: str(value) for key, value in result.items()})
        robot = self._summary["robot"]
        urdf = robot["urdf"].encode()
        self._writer.add_attachment(0, 0, f"{robot['name']}.urdf", "application/xml", urdf)
        links = read_links(robot, self._summary["joints"])
        self._put_bodies(links)
        for tick, time in enumerate(self._arrays["time"].tolist()):
            self._put("/tf", "foxglove.FrameTransforms", time, self._transforms(links, tick, time))
            self._put_numbers(tick, time)
        self._put_images()
        self._put_transitions()
        self._writer.finish()
        return self._count

    def _put(self, topic: str, schema: str, time: float, message: Json) -> None:
        # Channels are registered with their first message, so that a file lists no empty topic.
        if topic not in self._channels:
            if schema not in self._schemas:
                text = json.dumps(SCHEMAS[schema]).encode()
                self._schemas[schema] = self._writer.register_schema(schema, "jsonschema", text)
            number = self._schemas[schema]
            self._channels[topic] = self._writer.register_channel(topic, "json", number)
        stamp, data = round(time * _NANO), json.dumps(message, allow_nan=False).encode()
        self._writer.add_message(self._channels[topic], stamp, data, stamp)
        self._count += 1

    def _put_bodies(self, links: Sequence[DrawnLink]) -> None:
        """Write the shapes of the robot and of the objects, once, each in its own frame."""
        robot = [_entity(link.name, [shape._asdict() for shape in link.shapes]) for link in links]
        things = [_entity(f"thing/{n}", parts) for n, parts in self._summary["scene"].items()]
        for topic, entities in (("/robot", robot), ("/things", things)):
            self._put(topic, "foxglove.SceneUpdate", 0.0, {"deletions": [], "entities": entities})

    def _transforms(self, links: Sequence[DrawnLink], tick: int, time: float) -> Json:
        positions = self._arrays["positions"][tick]
        transforms = []
        for link in links:
            parent = WORLD if link.parent < 0 else links[link.parent].name
            place, turn = placed(link, positions)
            transforms.append(_transform(time, parent, link.name, place, turn))
        for name, pose in zip(self._summary["scene"], self._scene(tick), strict=True):
            # NaN marks an object that is not in the world at this tick.
            if not math.isnan(pose[0]):
                frame = f"thing/{name}"
                transforms.append(_transform(time, WORLD, frame, pose[:3], pose[3:]))
        return {"transforms": transforms}

    def _scene(self, tick: int) -> Floats:
        scene = self._arrays["scene"]
        return scene[tick] if len(scene) else np.zeros((0, 7))

    def _put_numbers(self, tick: int, time: float) -> None:
        stamp, arrays, summary = _stamp(time), self._arrays, self._summary
        joints: Json = {"timestamp": stamp, "names": list(summary["joints"])}
        joints |= {key: _numbers(arrays[key][tick]) for key in ("positions", "references")}
        self._put("/joint_states", "cbdsl.JointStates", time, joints)
        names = self._recorded.controllers
        values = dict(zip(names, _numbers(arrays["potentials"][tick]), strict=True))
        self._put("/potentials", "cbdsl.Values", time, {"timestamp": stamp, "values": values})
        letters = dict(zip(names, summary["predicates"][tick], strict=True))
        message = {"timestamp": stamp, "predicates": letters}
        self._put("/predicates", "cbdsl.Predicates", time, message)
        signals = {n: _numbers(array[tick].ravel()) for n, array in self._recorded.signals.items()}
        self._put("/signals", "cbdsl.Values", time, {"timestamp": stamp, "values": signals})

    def _put_images(self) -> None:
        times = self._arrays["image_time"].tolist()
        for name, images in self._recorded.images.items():
            for time, image in zip(times, images, strict=True):
                _, data = cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))
                text = base64.b64encode(data.tobytes()).decode()
                message = {"timestamp": _stamp(time), "frame_id": name, "data": text}
                message["format"] = "png"
                self._put(f"/camera/{name}", "foxglove.CompressedImage", time, message)

    def _put_transitions(self) -> None:
        result = self._summary["result"]
        lines = [
            (
                each["time"],
                title_of(each["program"], each.get("use", "")),
                f"{each['state']} -> {each['next_state']}  {each['words'] or each['action']}"
                + (f"  reward {each['reward']}" if each["reward"] else ""),
            )
            for each in self._recorded.transitions
        ]
        end = float(self._arrays["time"][-1]) if len(self._arrays["time"]) else 0.0
        for time, program, text in [*lines, (end, result["program"], result["ending"])]:
            message = {"timestamp": _stamp(time), "level": _INFO, "message": text, "name": program}
            self._put("/transitions", "foxglove.Log", time, {**message, "file": "", "line": 0})


def _stamp(time: float) -> Json:
    nanoseconds = round(time * _NANO)
    return {"sec": nanoseconds // _NANO, "nsec": nanoseconds % _NANO}


def _numbers(values: Floats) -> list[float | None]:
    """Return values, with ``None`` for undefined ones, because JSON has no NaN."""
    return [None if math.isnan(value) else float(value) for value in values]


def _transform(
    time: float, parent: str, child: str, place: Iterable[float], turn: Iterable[float]
) -> Json:
    return {
        "timestamp": _stamp(time),
        "parent_frame_id": parent,
        "child_frame_id": child,
        "translation": _named(place, "xyz"),
        "rotation": _named(turn, "xyzw"),
    }


def _named(values: Iterable[float], names: str) -> Json:
    return dict(zip(names, map(float, values), strict=True))


def _entity(frame: str, parts: Iterable[Mapping[str, Any]]) -> Json:
    """Return the shapes that are attached to a frame, as an entity of a scene."""
    shapes: dict[str, list[Json]] = {
        key: [] for key in ("arrows", "cubes", "spheres", "cylinders", "lines", "triangles",
                            "texts", "models")
    }  # fmt: skip
    for part in parts:
        pose = {
            "position": _named(part["position"], "xyz"),
            "orientation": _named(part["quaternion"], "xyzw"),
        }
        color = _named([*part["color"], 1.0], "rgba")
        kind, shape = _primitive(part, pose, color)
        shapes[kind].append(shape)
    return {
        "timestamp": _stamp(0.0), "frame_id": frame, "id": frame, "frame_locked": True,
        "lifetime": {"sec": 0, "nsec": 0}, "metadata": [], **shapes,
    }  # fmt: skip


def _primitive(part: Mapping[str, Any], pose: Json, color: Json) -> tuple[str, Json]:
    """Return a part as a primitive of a scene, and the list that it belongs to."""
    if part["shape"] == "mesh":
        mesh = part["mesh"]
        # A mesh of the robot was read from its file; a mesh of an object is in the recording.
        points, faces = mesh.values() if isinstance(mesh, Mapping) else mesh
        return "triangles", {
            "pose": pose,
            "points": [_named(point, "xyz") for point in points],
            "color": color,
            "colors": [],
            "indices": [int(index) for face in faces for index in face],
        }
    size = part["size"]
    if part["shape"] == "box":
        return "cubes", {"pose": pose, "size": _named(size, "xyz"), "color": color}
    if part["shape"] == "ball":
        edges = _named([2 * size[0]] * 3, "xyz")
        return "spheres", {"pose": pose, "size": edges, "color": color}
    edges = _named([2 * size[0], 2 * size[0], size[1]], "xyz")
    ends = {"bottom_scale": 1.0, "top_scale": 1.0}
    return "cylinders", {"pose": pose, "size": edges, **ends, "color": color}
