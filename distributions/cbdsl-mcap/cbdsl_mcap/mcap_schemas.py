"""JSON schemas of the messages in MCAP files, those of Foxglove under its names."""

from __future__ import annotations

from typing import Any

Json = dict[str, Any]

_NUMBER: Json = {"type": "number"}
_TEXT: Json = {"type": "string"}
_STAMP: Json = {
    "type": "object", "title": "time",
    "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}},
}  # fmt: skip
_SPAN: Json = {**_STAMP, "title": "duration"}


def _object(title: str, **properties: Json) -> Json:
    return {"type": "object", "title": title, "properties": properties}


def _list(items: Json) -> Json:
    return {"type": "array", "items": items}


def _vector(title: str, names: str) -> Json:
    return _object(title, **dict.fromkeys(names, _NUMBER))


_VECTOR = _vector("foxglove.Vector3", "xyz")
_POINT = _vector("foxglove.Point3", "xyz")
_QUATERNION = _vector("foxglove.Quaternion", "xyzw")
_COLOR = _vector("foxglove.Color", "rgba")
_POSE = _object("foxglove.Pose", position=_VECTOR, orientation=_QUATERNION)
_TRANSFORM = _object(
    "foxglove.FrameTransform", timestamp=_STAMP, parent_frame_id=_TEXT, child_frame_id=_TEXT,
    translation=_VECTOR, rotation=_QUATERNION,
)  # fmt: skip
_CUBE = _object("foxglove.CubePrimitive", pose=_POSE, size=_VECTOR, color=_COLOR)
_SPHERE = _object("foxglove.SpherePrimitive", pose=_POSE, size=_VECTOR, color=_COLOR)
_CYLINDER = _object(
    "foxglove.CylinderPrimitive", pose=_POSE, size=_VECTOR, bottom_scale=_NUMBER,
    top_scale=_NUMBER, color=_COLOR,
)  # fmt: skip
_TRIANGLES = _object(
    "foxglove.TriangleListPrimitive", pose=_POSE, points=_list(_POINT), color=_COLOR,
    colors=_list(_COLOR), indices=_list({"type": "integer"}),
)  # fmt: skip
_ANY: Json = _list({"type": "object"})
_ENTITY = _object(
    "foxglove.SceneEntity", timestamp=_STAMP, frame_id=_TEXT, id=_TEXT, lifetime=_SPAN,
    frame_locked={"type": "boolean"}, metadata=_ANY, arrows=_ANY, cubes=_list(_CUBE),
    spheres=_list(_SPHERE), cylinders=_list(_CYLINDER), lines=_ANY, triangles=_list(_TRIANGLES),
    texts=_ANY, models=_ANY,
)  # fmt: skip
_VALUE: Json = {"type": ["number", "null"]}

#: Schemas by the names of their messages.
SCHEMAS: dict[str, Json] = {
    schema["title"]: schema
    for schema in (
        _object("foxglove.FrameTransforms", transforms=_list(_TRANSFORM)),
        _object("foxglove.SceneUpdate", deletions=_ANY, entities=_list(_ENTITY)),
        _object(
            "foxglove.CompressedImage", timestamp=_STAMP, frame_id=_TEXT,
            data={"type": "string", "contentEncoding": "base64"}, format=_TEXT,
        ),
        _object(
            "foxglove.Log", timestamp=_STAMP, level={"type": "integer"}, message=_TEXT,
            name=_TEXT, file=_TEXT, line={"type": "integer"},
        ),
        _object(
            "cbdsl.JointStates", timestamp=_STAMP, names=_list(_TEXT), positions=_list(_VALUE),
            references=_list(_VALUE),
        ),
        _object("cbdsl.Values", timestamp=_STAMP, values={"type": "object"}),
        _object("cbdsl.Predicates", timestamp=_STAMP, predicates={"type": "object"}),
    )
}  # fmt: skip
