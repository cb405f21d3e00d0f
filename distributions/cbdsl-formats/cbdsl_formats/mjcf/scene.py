"""Stages for scenes in MJCF: fixtures, things and their places, as MuJoCo compiles them."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import mujoco as mj
import numpy as np

from cbdsl.extend.backend import Floats
from cbdsl.extend.model import ConvertedModel, UrdfError
from cbdsl_formats.mjcf.body_frame import BodyFrame, placed, turned
from cbdsl_formats.mjcf.conversion import color_of, compiled_model, is_hidden
from cbdsl_formats.mjcf.mjcf_model import distinct, model_corners, stl_of

# Smallest cosine between an axis of a solid and one of its frame that counts as parallel.
_PARALLEL = 0.9999
# Half the width of the floor in the place of an endless plane, and half its thickness, m.
_ENDLESS, _THIN = 2.0, 0.01
_MOST_PIECES = 16
# Words that YAML reads as other values than texts.
_NO_TEXT = re.compile("true|false|yes|no|on|off|null", re.IGNORECASE)
_UP = np.array([0.0, 0.0, 1.0])
_CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
_FACES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
     [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
)  # fmt: skip


class SceneSolid(NamedTuple):
    """SceneSolid of a body.

    Attributes:
        form: Shape and sizes as in stages; empty for a mesh.
        position: Centre in the frame of the object, m, shape (3,).
        yaw: Rotation about z, rad.
        corners: Corners of the triangles of a mesh about its centre, m, shape (n, 3, 3).
    """

    form: dict[str, Any]
    position: Floats
    yaw: float
    corners: Floats | None = None


def convert_scene(path: Path, name: str) -> ConvertedModel:
    """Return a stage with its meshes, and remarks about other parts.

    Args:
        path: Path of the scene.
        name: Name of the stage; its meshes are in the folder ``NAME_meshes``.

    Raises:
        UrdfError: If MuJoCo refuses the scene, or a stage can state none of its parts.
    """
    return _SceneConversion(path, compiled_model(path), name).converted()


# Model: a stage has fixtures that are parallel to the axes or turned about z, and things that stand
# at a yaw. A body's rotation is split into a yaw and a tilt, and the tilt is applied to its solids.
# Solids that stay tilted become meshes if they have corners; others are named with the reason. A
# stage moves no joints: of an articulated object, only the bodies that no joint moves are fixtures.
class _SceneConversion:
    def __init__(self, path: Path, compiled: Any, name: str) -> None:
        self._path, self._model, self._name = path, compiled, name
        self._names: set[str] = set()
        self._meshes: dict[str, bytes] = {}
        self._remarks: list[str] = []
        self._data = mj.MjData(compiled)
        mj.mj_forward(compiled, self._data)

    def converted(self) -> ConvertedModel:
        fixtures = dict(self._fixtures())
        things, places = {}, {}
        for body in range(1, self._model.nbody):
            if self._is_thing(body) and (thing := self._thing(body)):
                name = self._distinct(self._body_name(body))
                things[name], places[name] = thing
        self._name_moving()
        if not (fixtures or things):
            why = "; ".join(self._counted())
            raise UrdfError(
                f"{self._path}: it has no fixture and no thing that a stage can state"
                f"{f': {why}' if why else ''}"
            )
        placed_things = {name: {"things": [name], "place": place} for name, place in places.items()}
        remarks = self._counted()
        lines = [
            *_section("fixtures", fixtures),
            *_section("things", things),
            *_section("contexts", {"scene": {"placed": placed_things} if placed_things else {}}),
            *(f"# {remark}" for remark in remarks),
        ]
        return ConvertedModel("\n".join(lines) + "\n", self._meshes, remarks)

    def _counted(self) -> tuple[str, ...]:
        """Return the different remarks, each with its number if it occurs several times."""
        counts = Counter(self._remarks)
        return tuple(f"{each} ({n} times)" if n > 1 else each for each, n in counts.items())

    def _fixtures(self) -> Iterator[tuple[str, dict[str, Any]]]:
        """Yield the solids of all bodies that nothing moves, in the world frame."""
        model, seen = self._model, 0
        for body in range(model.nbody):
            if self._joints_above(body) or self._is_robot(body) or self._is_carried(body):
                continue
            frame = BodyFrame(self._data.xpos[body].copy(), self._data.xmat[body].reshape(3, 3))
            for geom in self._geoms(body):
                if not self._touches(geom):
                    seen += 1
                    continue
                name = model.geom(geom).name or (self._body_name(body) if body else "fixture")
                solid = self._solid(geom, frame, name)
                if solid is not None:
                    name, color = self._distinct(name), self._color(geom, self._geoms(body))
                    yield name, {
                        "form": self._form([solid], name), "position": _lengths(solid.position),
                        "color": color, "friction": _friction(model, geom),
                    }  # fmt: skip
        if seen:
            self._remarks.append(f"left out {seen} geoms of fixed bodies that nothing touches")

    def _thing(self, body: int) -> tuple[dict[str, Any], dict[str, Any]] | None:
        """Return a thing and its place; ``None`` with a remark if it has no form."""
        model, name = self._model, self._body_name(body)
        frames = list(self._starts(body))
        _, tilt = _split(frames[0].rotation)
        own = [
            (geom, BodyFrame(np.zeros(3), tilt).then(self._within(part, body)))
            for part in range(body, model.nbody)
            if int(model.body_rootid[part]) == body
            for geom in self._geoms(part)
        ]
        touching = [each for each in own if self._touches(each[0])]
        solids = [self._solid(geom, frame, name) for geom, frame in touching]
        kept = [solid for solid in solids if solid is not None]
        mass = float(model.body_subtreemass[body])
        if not kept or mass <= 0.0:
            reason = "no mass" if kept else "no solid that a stage can state"
            self._remarks.append(f"left out thing '{name}': it has {reason}")
            return None
        centre = _middle(kept)
        centred = [each._replace(position=each.position - centre) for each in kept]
        form = self._form(centred, name)
        color = self._color(touching[0][0], [geom for geom, _ in own])
        thing = {
            "form": form, "mass": f"{mass:.4g} kg", "color": color,
            "friction": _friction(model, touching[0][0]),
        }  # fmt: skip
        spots = []
        for frame in frames:
            yaw, _ = _split(frame.rotation)
            spots.append([*(frame.position + turned(_UP, yaw).rotation @ centre), yaw])
        x, y, z, turn = zip(*spots, strict=True)
        place = {key: _span(values, "m") for key, values in (("x", x), ("y", y), ("z", z))}
        return thing, {**place, "yaw": _span([math.degrees(each) for each in turn], "deg")}

    def _starts(self, body: int) -> Iterator[BodyFrame]:
        """Yield the frames of a free body as in the file, or at all keyframes if there are any."""
        model = self._model
        if not self._is_free(body):  # moved by six joints, at their places in the file
            yield BodyFrame(self._data.xpos[body].copy(), self._data.xmat[body].reshape(3, 3))
            return
        at = int(model.jnt_qposadr[model.body_jntadr[body]])
        for values in model.key_qpos if model.nkey else [model.qpos0]:
            pose = values[at : at + 7]
            yield placed(pose[:3], pose[3:])

    def _solid(self, geom: int, frame: BodyFrame, name: str) -> SceneSolid | None:
        """Return a geom in a frame; ``None`` with a remark if a stage cannot state it."""
        model = self._model
        place = frame.then(placed(model.geom_pos[geom], model.geom_quat[geom]))
        kind = mj.mjtGeom(int(model.geom_type[geom])).name.removeprefix("mjGEOM_").lower()
        size, at = model.geom_size[geom], place.position
        yaw, tilt = _split(place.rotation)
        upright = abs(place.rotation[2, 2]) > _PARALLEL
        if kind == "sphere":
            return SceneSolid({"shape": "ball", "radius": _length(size[0])}, at, 0.0)
        if kind == "plane" and place.rotation[2, 2] > _PARALLEL:
            halves = np.array([*(each or _ENDLESS for each in size[:2]), _THIN])
            return _box(halves, at - _THIN * _UP, yaw)
        if kind == "box":
            # After its yaw, the axes of the box are those of the frame in another order.
            order = np.abs(tilt)
            if bool((order.max(axis=0) > _PARALLEL).all()):
                return _box(order.round() @ size, at, yaw)
            return SceneSolid({}, at, 0.0, (_CORNERS * size @ place.rotation.T)[_FACES])
        if kind in ("cylinder", "capsule") and upright:
            if kind == "capsule":
                self._remarks.append(f"capsule of '{name}' is a cylinder of its whole height here")
            height = 2 * size[1] + (2 * size[0] if kind == "capsule" else 0.0)
            form = {"shape": "cylinder", "radius": _length(size[0]), "height": _length(height)}
            return SceneSolid(form, at, 0.0)
        if kind == "mesh":
            corners = model_corners(model, int(model.geom_dataid[geom])) @ place.rotation.T
            middle = (corners.min(axis=(0, 1)) + corners.max(axis=(0, 1))) / 2
            return SceneSolid({}, at + middle, 0.0, corners - middle)
        how = "a tilted" if kind in ("cylinder", "capsule", "plane") else "an unknown form,"
        self._remarks.append(f"left out of '{name}': {how} {kind}")
        return None

    def _form(self, solids: list[SceneSolid], name: str) -> dict[str, Any]:
        """Return the form of one or several solids about their middle."""
        if len(solids) == 1 and solids[0].corners is None and not solids[0].yaw:
            return solids[0].form
        meshes = [each for each in solids if each.corners is not None]
        if not meshes and len(solids) <= _MOST_PIECES:
            pieces = [
                {
                    "form": each.form, "position": _lengths(each.position * (len(solids) > 1)),
                    "yaw": f"{math.degrees(each.yaw):.4g} deg",
                }
                for each in solids
            ]  # fmt: skip
            return {"shape": "composed", "pieces": pieces}
        if len(meshes) < len(solids):
            self._remarks.append(f"left out of '{name}': {len(solids) - len(meshes)} solids")
        corners = [
            each.corners + (each.position if len(solids) > 1 else 0.0)
            for each in meshes
            if each.corners is not None
        ]
        file = f"{self._name}_meshes/{name}.stl"
        self._meshes[file] = stl_of(np.concatenate(corners))
        return {"shape": "mesh", "file": file, "scale": "1 m"}

    def _name_moving(self) -> None:
        """Remark on the joints and bodies that move in ways that no stage states."""
        model = self._model
        jointed: dict[str, list[str]] = {}
        for joint in range(model.njnt):
            body = int(model.jnt_bodyid[joint])
            root = self._body_name(int(model.body_rootid[body]))
            if not self._is_thing(int(model.body_rootid[body])):
                name = model.joint(joint).name or f"joint {joint}"
                jointed.setdefault(root, []).append(name)
        for root, names in jointed.items():
            listed = ", ".join(names[:4]) + (f" and {len(names) - 4} others" if names[4:] else "")
            self._remarks.append(
                f"left out what moves of '{root}': a stage has no joint ({listed}); "
                "cb new robot reads that of a robot"
            )
        for body in range(1, model.nbody):
            if model.body_mocapid[body] >= 0:
                self._remarks.append(f"left out '{self._body_name(body)}': a mocap body")

    def _color(self, geom: int, others: Iterable[int]) -> list[float]:
        """Return the color of a geom, or of the first visible one among others if it is hidden."""
        visible = (each for each in (geom, *others) if not is_hidden(self._model, each))
        color = color_of(self._model, next(visible, geom))
        return [round(min(max(each, 0.0), 1.0), 3) for each in color[:3]]

    def _body_name(self, body: int) -> str:
        return str(self._model.body(body).name) or f"body_{body}"

    def _distinct(self, name: str) -> str:
        plain = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")
        is_name = plain[:1].isalpha() and not _NO_TEXT.fullmatch(plain)
        return distinct(plain if is_name else f"part_{plain}", self._names)

    def _geoms(self, body: int) -> range:
        first = int(self._model.body_geomadr[body])
        return range(first, first + int(self._model.body_geomnum[body]))

    def _touches(self, geom: int) -> bool:
        return bool(self._model.geom_contype[geom] or self._model.geom_conaffinity[geom])

    def _joints_above(self, body: int) -> int:
        """Return the number of joints between a body and the world."""
        model, count = self._model, 0
        while body:
            count += int(model.body_jntnum[body])
            body = int(model.body_parentid[body])
        return count

    def _is_carried(self, body: int) -> bool:
        """Return whether a mocap body carries a body."""
        return bool(body) and int(self._model.body_mocapid[self._model.body_rootid[body]]) >= 0

    def _joints_of(self, root: int) -> list[int]:
        model = self._model
        return [n for n in range(model.njnt) if model.body_rootid[model.jnt_bodyid[n]] == root]

    def _is_robot(self, body: int) -> bool:
        """Return whether a body belongs to a tree with a driven joint."""
        model = self._model
        driven = set(model.actuator_trnid[:, 0].tolist())
        return bool(body) and bool(driven & {*self._joints_of(int(model.body_rootid[body]))})

    def _is_thing(self, body: int) -> bool:
        """Return whether a body can move in all directions, and no joint moves a part of it."""
        model, own = self._model, self._joints_of(body)
        slides = [n for n in own if int(model.jnt_type[n]) == int(mj.mjtJoint.mjJNT_SLIDE)]
        is_alone = all(int(model.jnt_bodyid[n]) == body for n in own)
        ways = int(np.linalg.matrix_rank(model.jnt_axis[slides])) if slides else 0
        return is_alone and not self._is_robot(body) and (self._is_free(body) or ways == 3)

    def _is_free(self, body: int) -> bool:
        own = self._joints_of(body)
        free = int(mj.mjtJoint.mjJNT_FREE)
        return len(own) == 1 and int(self._model.jnt_type[own[0]]) == free

    def _within(self, body: int, root: int) -> BodyFrame:
        """Return the frame of a body in that of its root."""
        frame = BodyFrame(np.zeros(3), np.eye(3))
        while body != root:
            own = placed(self._model.body_pos[body], self._model.body_quat[body])
            frame, body = own.then(frame), int(self._model.body_parentid[body])
        return frame


def _split(rotation: Floats) -> tuple[float, Floats]:
    """Return the yaw of a rotation, rad, and the tilt before it, shape (3, 3)."""
    # The most level axis shows the yaw.
    level = int(np.argmin(np.abs(rotation[2])))
    yaw = math.atan2(rotation[1, level], rotation[0, level])
    # Solids of the stage look the same after quarter turns of their axes.
    yaw = (yaw + math.pi / 4) % (math.pi / 2) - math.pi / 4
    return yaw, turned(_UP, -yaw).rotation @ rotation


def _box(halves: Floats, at: Floats, yaw: float) -> SceneSolid:
    yaw = 0.0 if abs(yaw) < 1e-3 else yaw
    return SceneSolid({"shape": "box", "size": _lengths(2 * halves)}, at, yaw)


def _middle(solids: list[SceneSolid]) -> Floats:
    """Return the middle of the box around solids, m."""
    ends = [each.position + corner for each in solids for corner in _reach(each)]
    middle: Floats = (np.min(ends, axis=0) + np.max(ends, axis=0)) / 2
    return middle


def _reach(solid: SceneSolid) -> Floats:
    """Return two corners of the box around a solid, about its centre, m."""
    if solid.corners is not None:
        return np.array([solid.corners.min(axis=(0, 1)), solid.corners.max(axis=(0, 1))])
    sizes = [float(text.split()[0]) for text in _sizes(solid.form)]
    x, y, z = sizes if len(sizes) == 3 else (2 * sizes[0], 2 * sizes[0], (*sizes, 2 * sizes[0])[1])
    c, s = abs(math.cos(solid.yaw)), abs(math.sin(solid.yaw))
    half = (
        np.array([c * x + s * y, s * x + c * y, z]) / 2
        if len(sizes) == 3
        else np.array([x, y, z]) / 2
    )
    return np.array([-half, half])


def _sizes(form: Mapping[str, Any]) -> list[str]:
    if form["shape"] == "box":
        return list(form["size"])
    return [form[key] for key in ("radius", "height") if key in form]


def _length(value: float) -> str:
    return f"{value:.5g} m"


def _lengths(values: Iterable[float]) -> list[str]:
    return [_length(round(float(value), 6) + 0.0) for value in values]


def _span(values: Iterable[float], unit: str) -> str | list[str]:
    """Return a value, or a range if values differ."""
    texts = [f"{round(each, 6) + 0.0:.5g} {unit}" for each in (min(values), max(values))]
    return texts[0] if texts[0] == texts[1] else texts


def _friction(model: Any, geom: int) -> float:
    return round(float(model.geom_friction[geom, 0]), 3)


def _section(key: str, entries: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of a section."""
    if entries:
        yield f"{key}:"
        yield from (f"  {name}: {_flow(value)}" for name, value in entries.items())


def _flow(value: Any) -> str:
    """Return a value in YAML's flow style; its texts are names, files and quantities."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {_flow(each)}" for key, each in value.items()) + "}"
    return "[" + ", ".join(map(_flow, value)) + "]" if isinstance(value, list) else str(value)
