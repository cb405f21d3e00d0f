"""Conversion of MJCF models to URDF.

Bodies and sites become links; joints keep their names and positions. In every posture, the links of
the URDF are at the places of the model's bodies and sites. Several joints of one body become a
series of links.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import mujoco as mj
import numpy as np

from cbdsl.extend.backend import Floats
from cbdsl.extend.model import MOST_BYTES, ConvertedModel, UrdfError, contents, xml_root
from cbdsl_formats.mjcf.body_frame import BodyFrame, moved, placed, turned
from cbdsl_formats.mjcf.mjcf_model import MjcfJoint, MjcfModel

# Mass, kg, and inertia, kg m^2, of the additional links for sites and for bodies with several
# joints. Some simulators assume 1 kg for a link without mass.
LEAST_MASS, LEAST_INERTIA = 1e-6, 1e-9
# First of the geom groups that MuJoCo's viewer hides by default.
_HIDDEN_GROUP = 3
_COUNTS = ("count", "nrow", "ncol", "width", "height")
_MOST_COPIES, _MOST_PIXELS = 10_000, 100_000_000
# Characters that MuJoCo allows in names and that XML, the syntax of URDF, cannot represent.
_UNWRITABLE = re.compile(r"[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def convert_mjcf(path: Path, name: str) -> ConvertedModel:
    """Return the URDF of an MJCF model.

    Args:
        path: Path of the model, whose includes and meshes MuJoCo finds.
        name: Name of the robot; its meshes are in the folder ``NAME_meshes``.

    Raises:
        UrdfError: If MuJoCo refuses the model, or a joint is a ball joint.
    """
    try:
        converted = _converted(MjcfModel(path, compiled_model(path)), name)
    except UnicodeDecodeError as error:
        raise UrdfError(f"{path}: one of its names is not UTF-8 ({error})") from None
    unwritable = _UNWRITABLE.search(converted.text)
    if unwritable is not None:
        raise UrdfError(f"{path}: one of its names has the control character {unwritable[0]!r}")
    return converted


def compiled_model(path: Path) -> Any:
    """Return a model as MuJoCo compiles it.

    Raises:
        UrdfError: If MuJoCo refuses it, or it repeats a part too often.
    """
    _require_few_copies(path)
    try:
        return mj.MjModel.from_xml_path(str(path))
    except ValueError as error:
        reason = " ".join(str(error).split())
        raise UrdfError(f"{path}: MuJoCo cannot compile it: {reason}") from None


def _require_few_copies(path: Path) -> None:
    """Check the number of a model's repeated parts, before MuJoCo creates them.

    Raises:
        UrdfError: If there are more than a robot can have.
    """
    try:
        root = xml_root(contents(path, MOST_BYTES), path, "MJCF")
    except (OSError, UrdfError):
        return  # MuJoCo reports it
    waiting = [(root, 1)]
    while waiting:
        element, copies = waiting.pop()
        # Nested replications multiply, so that a few lines can request billions of bodies.
        for word in " ".join(element.get(key, "") for key in _COUNTS).split():
            copies *= int(word) if word.isascii() and word.isdigit() and len(word) < 12 else 1
        most = _MOST_COPIES if element.get("count") else _MOST_PIXELS
        if copies > most:
            raise UrdfError(
                f"{path}: <{element.tag}> makes {copies} copies of a part; at most {most} are read"
            )
        waiting += [(child, copies) for child in element]


def _converted(model: MjcfModel, name: str) -> ConvertedModel:
    writer = _Writer(model, name)
    meshes = {file: model.stl(mesh) for file, mesh in writer.meshes.items()}
    indent(writer.robot)
    return ConvertedModel(
        tostring(writer.robot, encoding="unicode"), meshes, tuple(model.remarks())
    )


class _Writer:
    """Writer of the robot's XML.

    Attributes:
        robot: Root element.
        meshes: Numbers of the used meshes, by their files' names.
    """

    def __init__(self, model: MjcfModel, name: str) -> None:
        self._model, self._name = model, name
        self.robot = Element("robot", name=name)
        self.meshes: dict[str, int] = {}
        SubElement(self.robot, "link", name="world")
        for body in model.bodies():
            self._add_body(body)
        for site in range(model.compiled.nsite):
            self._add_site(site)

    # An MJCF body owns its joints: they move it in their order, each about an anchor in the body's
    # frame. A URDF joint moves one link about the origin of that link. Each joint of a body
    # therefore gets a link whose origin is at the joint's anchor. If the last anchor differs from
    # the body's origin, a fixed joint leads back to it. MuJoCo places the bodies as written at the
    # positions qpos0, and URDF at 0. The origin of each joint thus contains its motion by -qpos0
    # about or along its axis. For slides the anchor has no effect.
    def _add_body(self, body: int) -> None:
        model, name = self._model, self._model.links[body]
        parent, placement, anchor = model.parent(body), model.placement(body), np.zeros(3)
        joints = model.joints(body)
        for number, joint in enumerate(joints):
            # The place of its axis does not matter for a slide.
            next_anchor = anchor if joint.slides else joint.anchor
            at_zero = (
                moved(-joint.zero * joint.axis) if joint.slides else turned(joint.axis, -joint.zero)
            )
            origin = placement.then(moved(next_anchor - anchor)).then(at_zero)
            is_last = number == len(joints) - 1 and not next_anchor.any()
            child = name if is_last else f"{name}_{number + 1}"
            self._add_joint(joint, parent, child, origin)
            if not is_last:
                self._add_light_link(child)
            parent, placement, anchor = child, moved(np.zeros(3)), next_anchor
        if not joints or anchor.any():
            self._fix(f"{name}_fixed", parent, name, placement.then(moved(-anchor)))
        link = SubElement(self.robot, "link", name=name)
        self._add_inertial(link, body)
        self._add_geoms(link, body)

    def _add_site(self, site: int) -> None:
        model = self._model.compiled
        body, name = int(model.site_bodyid[site]), self._model.sites[site]
        if int(model.body_rootid[body]) in self._model.left_out:
            return
        placement = placed(model.site_pos[site], model.site_quat[site])
        self._fix(f"{name}_fixed", self._model.links[body], name, placement)
        self._add_light_link(name)

    def _add_joint(self, joint: MjcfJoint, parent: str, child: str, origin: BodyFrame) -> None:
        model, number = self._model.compiled, joint.number
        limited = bool(model.jnt_limited[number])
        kind = "prismatic" if joint.slides else "revolute" if limited else "continuous"
        element = SubElement(self.robot, "joint", name=joint.name, type=kind)
        _add_origin(element, origin)
        SubElement(element, "parent", link=parent)
        SubElement(element, "child", link=child)
        SubElement(element, "axis", xyz=_numbers(joint.axis))
        # MJCF has no velocity limit; 0 means unlimited.
        limit = SubElement(
            element, "limit", effort=_number(self._model.effort(number)), velocity="0"
        )
        if limited:
            lower, upper = model.jnt_range[number]
            limit.set("lower", _number(lower))
            limit.set("upper", _number(upper))
        if joint.mimic is not None:
            master, ratio, offset = joint.mimic
            SubElement(
                element, "mimic", joint=master, multiplier=_number(ratio), offset=_number(offset)
            )
        row = int(model.jnt_dofadr[number])
        damping, friction = self._damping(row), float(model.dof_frictionloss[row])
        SubElement(element, "dynamics", damping=_number(damping), friction=_number(friction))

    def _damping(self, row: int) -> float:
        """Return the damping of a joint; its first coefficient if MuJoCo has several."""
        return float(np.ravel(self._model.compiled.dof_damping[row])[0])

    def _fix(self, name: str, parent: str, child: str, origin: BodyFrame) -> None:
        element = SubElement(self.robot, "joint", name=name, type="fixed")
        _add_origin(element, origin)
        SubElement(element, "parent", link=parent)
        SubElement(element, "child", link=child)

    def _add_light_link(self, name: str) -> None:
        link = SubElement(self.robot, "link", name=name)
        _add_mass(link, moved(np.zeros(3)), LEAST_MASS, [LEAST_INERTIA] * 3)

    def _add_inertial(self, link: Element, body: int) -> None:
        model = self._model.compiled
        mass = float(model.body_mass[body])
        if mass == 0.0:
            _add_mass(link, moved(np.zeros(3)), LEAST_MASS, [LEAST_INERTIA] * 3)
            return
        place = placed(model.body_ipos[body], model.body_iquat[body])
        _add_mass(link, place, mass, list(map(float, model.body_inertia[body])))

    def _add_geoms(self, link: Element, body: int) -> None:
        model = self._model.compiled
        first, many = int(model.body_geomadr[body]), int(model.body_geomnum[body])
        for geom in range(first, first + many):
            shapes = self._shapes(geom)
            if not shapes:
                name = model.geom(geom).name or f"geom {geom - first} of {self._model.links[body]}"
                self._model.unknown_geoms.append(name)
            for use in _uses(model, geom):
                for place, tag, sizes in shapes:
                    element = SubElement(link, use)
                    _add_origin(element, place)
                    SubElement(SubElement(element, "geometry"), tag, sizes)
                    if use == "visual":
                        _add_color(element, color_of(model, geom), f"geom_{geom}")

    def _shapes(self, geom: int) -> list[tuple[BodyFrame, str, dict[str, str]]]:
        """Return the URDF shapes of a geom: their placements, kinds and sizes."""
        model = self._model.compiled
        place = placed(model.geom_pos[geom], model.geom_quat[geom])
        kind = mj.mjtGeom(int(model.geom_type[geom])).name.removeprefix("mjGEOM_").lower()
        size = model.geom_size[geom]
        radius, height = _number(size[0]), _number(2 * size[1])
        if kind == "sphere":
            return [(place, "sphere", {"radius": radius})]
        if kind == "box":
            return [(place, "box", {"size": _numbers(2 * size)})]
        if kind == "cylinder":
            return [(place, "cylinder", {"radius": radius, "length": height})]
        if kind == "capsule":
            # URDF has no capsule, but its parts.
            ends = [place.then(moved([0.0, 0.0, end])) for end in (-size[1], size[1])]
            tube = (place, "cylinder", {"radius": radius, "length": height})
            return [tube, *((end, "sphere", {"radius": radius}) for end in ends)]
        if kind == "mesh":
            return [(place, "mesh", {"filename": self._mesh(int(model.geom_dataid[geom]))})]
        return []

    def _mesh(self, mesh: int) -> str:
        """Return the file of a mesh, which is written once for all its geoms."""
        plain = re.sub(r"[^\w.-]+", "_", self._model.compiled.mesh(mesh).name, flags=re.ASCII)
        file = f"{self._name}_meshes/{plain or mesh}.stl"
        if self.meshes.get(file, mesh) != mesh:
            file = f"{self._name}_meshes/{plain}_{mesh}.stl"
        self.meshes[file] = mesh
        return file


def _uses(model: Any, geom: int) -> list[str]:
    """Return whether a geom is visual, collision geometry or both.

    By convention, the groups from 3 on contain collision shapes.
    """
    hidden = is_hidden(model, geom)
    touches = bool(model.geom_contype[geom] or model.geom_conaffinity[geom])
    return [
        *([] if hidden else ["visual"]),
        *(["collision"] if touches or hidden else []),
    ]


def is_hidden(model: Any, geom: int) -> bool:
    """Return whether MuJoCo's viewer hides a geom."""
    return int(model.geom_group[geom]) >= _HIDDEN_GROUP or color_of(model, geom)[3] == 0.0


def color_of(model: Any, geom: int) -> list[float]:
    """Return red, green, blue and opacity of a geom, from its material if it has one."""
    material = int(model.geom_matid[geom])
    rgba = model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]
    return [float(each) for each in rgba]


def _add_color(visual: Element, rgba: list[float], name: str) -> None:
    material = SubElement(visual, "material", name=name)
    SubElement(material, "color", rgba=" ".join(f"{each:.4g}" for each in rgba))


def _add_mass(link: Element, place: BodyFrame, mass: float, moments: list[float]) -> None:
    """Add mass and principal moments of inertia, about the axes of a placement."""
    inertial = SubElement(link, "inertial")
    _add_origin(inertial, place)
    SubElement(inertial, "mass", value=_number(mass))
    xx, yy, zz = map(_number, moments)
    SubElement(inertial, "inertia", ixx=xx, iyy=yy, izz=zz, ixy="0", ixz="0", iyz="0")


def _add_origin(element: Element, place: BodyFrame) -> None:
    SubElement(element, "origin", xyz=_numbers(place.position), rpy=_numbers(_rpy(place.rotation)))


def _rpy(rotation: Floats) -> tuple[float, float, float]:
    """Return turns about the fixed x, then y, then z axis, rad.

    The roll is the remainder after yaw and pitch, so that all are exact at a pitch of 90 deg, too.
    """
    # With R = Rz(yaw) Ry(pitch) Rx(roll), the first column of R is (cy cp, sy cp, -sp). The second
    # row of Rz(yaw)' R is (0, cos(roll), -sin(roll)) at every pitch. At a pitch of 90 deg the first
    # column has no horizontal part. Only the sum or difference of roll and yaw is then defined, and
    # yaw is 0.
    r = rotation
    yaw = math.atan2(r[1, 0], r[0, 0]) if math.hypot(r[0, 0], r[1, 0]) > 1e-12 else 0.0
    c, s = math.cos(yaw), math.sin(yaw)
    pitch = math.atan2(-r[2, 0], c * r[0, 0] + s * r[1, 0])
    roll = math.atan2(s * r[0, 2] - c * r[1, 2], c * r[1, 1] - s * r[0, 1])
    return roll, pitch, yaw


def _number(value: float) -> str:
    # Adding 0.0 avoids a negative zero.
    return f"{float(value) + 0.0:.17g}"


def _numbers(values: Iterable[float]) -> str:
    return " ".join(map(_number, values))
