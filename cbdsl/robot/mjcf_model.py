"""MJCF models as URDF, by MuJoCo's own compiler; the only home of MuJoCo outside of its backend.

Bodies and sites become links, joints keep their names and positions: where the model's bodies and
sites are in a posture, the URDF's links are. Several joints of one body become a row of links.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import mujoco as mj
import numpy as np
from numpy.typing import NDArray

from cbdsl.errors.counting import count
from cbdsl.robot.urdf import UrdfError

Floats = NDArray[np.float64]

# Of links that a body of several joints, or a site, is given: mass, kg, and inertia, kg m^2. Some
# simulators take a link without mass for one of 1 kg.
LEAST_MASS, LEAST_INERTIA = 1e-6, 1e-9
# Geoms of the groups from this one on are not shown by MuJoCo's viewer, unless asked to.
_HIDDEN_GROUP = 3
# Of stages, and how much that of a model may differ without a word, m/s^2.
_GRAVITY, _GRAVITY_TOLERANCE = 9.81, 0.05


class MjcfConversion(NamedTuple):
    """A model in URDF.

    Attributes:
        urdf: its text.
        meshes: STL files by the name that the text has for them.
        remarks: sentences about parts of the model that have no counterpart in URDF.
    """

    urdf: str
    meshes: dict[str, bytes]
    remarks: tuple[str, ...]


def convert_mjcf(path: Path, name: str) -> MjcfConversion:
    """The URDF of an MJCF model.

    Args:
        path: of the model, whose includes and meshes MuJoCo finds.
        name: of the robot; its meshes are in the folder ``NAME_meshes``.

    Raises:
        UrdfError: MuJoCo refuses the model, or a joint is a ball joint.
    """
    try:
        compiled = mj.MjModel.from_xml_path(str(path))
    except ValueError as error:
        reason = " ".join(str(error).split())
        raise UrdfError(f"{path}: MuJoCo cannot compile it: {reason}") from None
    model = _Mjcf(path, compiled)
    writer = _Writer(model, name)
    meshes = {file: model.stl(mesh) for file, mesh in writer.meshes.items()}
    indent(writer.robot)
    return MjcfConversion(
        tostring(writer.robot, encoding="unicode"), meshes, tuple(model.remarks())
    )


class _Turn(NamedTuple):
    """A placement: position, m, shape (3,), and rotation matrix, shape (3, 3)."""

    position: Floats
    rotation: Floats

    def then(self, other: _Turn) -> _Turn:
        return _Turn(self.position + self.rotation @ other.position, self.rotation @ other.rotation)


def _moved(position: Iterable[float]) -> _Turn:
    return _Turn(np.array(position, dtype=np.float64), np.eye(3))


def _placed(position: Floats, quaternion: Floats) -> _Turn:
    rotation = np.zeros(9)
    mj.mju_quat2Mat(rotation, np.asarray(quaternion, dtype=np.float64))
    return _Turn(np.array(position, dtype=np.float64), rotation.reshape(3, 3))


def _turned(axis: Floats, angle: float) -> _Turn:
    quaternion = np.zeros(4)
    mj.mju_axisAngle2Quat(quaternion, np.asarray(axis, dtype=np.float64), angle)
    return _placed(np.zeros(3), quaternion)


class _Joint(NamedTuple):
    """A hinge or slide of the model, and what URDF says of it.

    Attributes:
        number: in the compiled model.
        slides: whether it slides.
        zero: its position where bodies are as they are nested in the model, rad or m.
        anchor, axis: in the body's frame, shape (3,).
        mimic: the joint that it follows, with multiplier and offset, if any.
    """

    number: int
    name: str
    slides: bool
    zero: float
    anchor: Floats
    axis: Floats
    mimic: tuple[str, float, float] | None


class _Mjcf:
    """A compiled model by the names and in the terms of URDF.

    Args:
        path: names it in messages.
        compiled: MuJoCo's model.

    Raises:
        UrdfError: one of its joints is a ball joint.
    """

    def __init__(self, path: Path, compiled: Any) -> None:
        self.path, self.compiled = path, compiled
        names: set[str] = {"world"}
        self.links = ["world"] + [
            _distinct(compiled.body(body).name or f"body_{body}", names)
            for body in range(1, compiled.nbody)
        ]
        self.sites = [
            _distinct(compiled.site(site).name or f"site_{site}", names)
            for site in range(compiled.nsite)
        ]
        self._require_hinges()
        self.joint_names = self._name_joints()
        self.driven = self._driven()
        self.unmatched_equalities: list[str] = []
        self.mimics = self._mimics()
        self.left_out = {body for body in range(1, compiled.nbody) if self._is_thing(body)}
        self.unknown_geoms: list[str] = []

    def bodies(self) -> list[int]:
        """Bodies that belong to the robot, each after the one that carries it."""
        model = self.compiled
        return [
            body
            for body in range(1, model.nbody)
            if int(model.body_rootid[body]) not in self.left_out
        ]

    def parent(self, body: int) -> str:
        """The link that carries a body."""
        return self.links[int(self.compiled.body_parentid[body])]

    def placement(self, body: int) -> _Turn:
        """A body in the frame of the one that carries it, with all joints as in the file."""
        return _placed(self.compiled.body_pos[body], self.compiled.body_quat[body])

    def joints(self, body: int) -> list[_Joint]:
        """The hinges and slides of a body, in the order in which they move it."""
        model = self.compiled
        first, many = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        numbers = [n for n in range(first, first + many) if self._kind(n) != "free"]
        return [
            _Joint(
                number=number,
                name=self.joint_names[number],
                slides=self._kind(number) == "slide",
                zero=self._zero(number),
                anchor=np.array(model.jnt_pos[number]),
                axis=np.array(model.jnt_axis[number]),
                mimic=self.mimics.get(number),
            )
            for number in numbers
        ]

    def effort(self, joint: int) -> float:
        """The largest torque or force of a joint's actuators, N m or N; 0 leaves it open."""
        model = self.compiled
        most = sum(self._force(each) for each in self.driven.get(joint, ()))
        if model.jnt_actfrclimited[joint]:
            bound = float(np.abs(model.jnt_actfrcrange[joint]).max())
            most = min(most or math.inf, bound)
        return most if math.isfinite(most) else 0.0

    def stl(self, mesh: int) -> bytes:
        """A mesh as binary STL, in the frame that MuJoCo has given it."""
        model = self.compiled
        start, many = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        corners = model.mesh_vert[start : start + many]
        start, many = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
        faces = model.mesh_face[start : start + many]
        record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("unused", "<u2")])
        triangles = np.zeros(many, dtype=record)
        triangles["corners"] = corners[faces]
        return bytes(80) + many.to_bytes(4, "little") + bytes(triangles.tobytes())

    def remarks(self) -> Iterator[str]:
        """Sentences about parts that have no counterpart in URDF."""
        model = self.compiled
        free = [self.links[self._body(n)] for n in self._numbers("free")]
        held = [link for link in free if self.links.index(link) not in self.left_out]
        things = [self.links[body] for body in sorted(self.left_out)]
        scenery = int(np.count_nonzero(model.geom_bodyid == 0))
        tendons = [model.tendon(n).name or f"tendon {n}" for n in range(model.ntendon)]
        others = [
            model.actuator(n).name or f"actuator {n}"
            for n in range(model.nu)
            if not self._acts_on_joint(n)
        ]
        idle = [
            name
            for number, name in enumerate(self.joint_names)
            if self._kind(number) != "free"
            and self._in_robot(number)
            and number not in self.driven
            and number not in self.mimics
        ]
        gravity = float(np.linalg.norm(model.opt.gravity))
        if abs(gravity - _GRAVITY) > _GRAVITY_TOLERANCE:
            yield (
                f"its gravity is {gravity:.3g} m/s^2, and programs run under {_GRAVITY:g}: efforts "
                "that hold it there may not hold it here"
            )
        yield from _remark(held, "can move freely in the model, and is fixed in space here")
        yield from _remark(things, "is a thing beside the robot, which belongs on a stage")
        if scenery:
            yield f"left out {count(scenery, 'geom')} of the world, which belong on a stage"
        yield from _remark(self.unknown_geoms, "has a form that URDF does not know")
        yield from _remark(self.unmatched_equalities, "is an equality that URDF cannot state")
        yield from _remark(tendons, "is a tendon, which URDF does not know")
        yield from _remark(others, "is an actuator of something else than a joint")
        yield from _remark(idle, "is a joint without an actuator, which programs can move here")

    def _require_hinges(self) -> None:
        ball = next((n for n in range(self.compiled.njnt) if self._kind(n) == "ball"), None)
        if ball is not None:
            name = self.compiled.joint(ball).name or f"number {ball}"
            raise UrdfError(
                f"{self.path}: joint '{name}' of body '{self.links[self._body(ball)]}' is a ball "
                "joint, which URDF does not know; three hinges of different axes do the same"
            )

    def _kind(self, joint: int) -> str:
        kind = mj.mjtJoint(int(self.compiled.jnt_type[joint]))
        return str(kind.name).removeprefix("mjJNT_").lower()

    def _numbers(self, kind: str) -> list[int]:
        return [n for n in range(self.compiled.njnt) if self._kind(n) == kind]

    def _body(self, joint: int) -> int:
        return int(self.compiled.jnt_bodyid[joint])

    def _in_robot(self, joint: int) -> bool:
        return int(self.compiled.body_rootid[self._body(joint)]) not in self.left_out

    def _zero(self, joint: int) -> float:
        return float(self.compiled.qpos0[self.compiled.jnt_qposadr[joint]])

    def _name_joints(self) -> list[str]:
        names: set[str] = set()
        return [
            _distinct(self.compiled.joint(n).name or f"{self.links[self._body(n)]}_joint", names)
            for n in range(self.compiled.njnt)
        ]

    def _is_thing(self, body: int) -> bool:
        """Whether a body is a thing beside the robot: free, or moved by hand, without joints."""
        model = self.compiled
        if int(model.body_parentid[body]) != 0:
            return False
        if model.body_mocapid[body] >= 0:
            return True
        own = [n for n in range(model.njnt) if model.body_rootid[self._body(n)] == body]
        others = any(model.body_rootid[self._body(n)] != body for n in range(model.njnt))
        return others and [self._kind(n) for n in own] == ["free"]

    def _acts_on_joint(self, actuator: int) -> bool:
        kinds = (mj.mjtTrn.mjTRN_JOINT, mj.mjtTrn.mjTRN_JOINTINPARENT)
        return int(self.compiled.actuator_trntype[actuator]) in map(int, kinds)

    def _driven(self) -> dict[int, list[int]]:
        """Actuators by the joint that they act on."""
        driven: dict[int, list[int]] = {}
        for actuator in range(self.compiled.nu):
            if self._acts_on_joint(actuator):
                joint = int(self.compiled.actuator_trnid[actuator, 0])
                driven.setdefault(joint, []).append(actuator)
        return driven

    def _force(self, actuator: int) -> float:
        """The largest force of an actuator on its joint; infinite without a bound."""
        model = self.compiled
        gear = abs(float(model.actuator_gear[actuator, 0]))
        if model.actuator_forcelimited[actuator]:
            return gear * float(np.abs(model.actuator_forcerange[actuator]).max())
        is_motor = (
            int(model.actuator_gaintype[actuator]) == int(mj.mjtGain.mjGAIN_FIXED)
            and int(model.actuator_biastype[actuator]) == int(mj.mjtBias.mjBIAS_NONE)
            and int(model.actuator_dyntype[actuator]) == int(mj.mjtDyn.mjDYN_NONE)
        )
        if is_motor and model.actuator_ctrllimited[actuator]:
            gain = abs(float(model.actuator_gainprm[actuator, 0]))
            return gear * gain * float(np.abs(model.actuator_ctrlrange[actuator]).max())
        return math.inf

    def _mimics(self) -> dict[int, tuple[str, float, float]]:
        """Joints that an equality makes proportional to another, by their number."""
        model = self.compiled
        mimics: dict[int, tuple[str, float, float]] = {}
        for number in range(model.neq):
            pair = self._proportional(number)
            if pair is None or pair[0] in mimics or pair[1] in mimics:
                self.unmatched_equalities.append(model.equality(number).name or f"number {number}")
                continue
            follower, master, ratio, offset = pair
            mimics[follower] = (self.joint_names[master], ratio, offset)
        return mimics

    def _proportional(self, number: int) -> tuple[int, int, float, float] | None:
        """Follower, followed joint, multiplier and offset of an equality, if it is a linear one."""
        model = self.compiled
        follower, master = int(model.eq_obj1id[number]), int(model.eq_obj2id[number])
        is_joint = int(model.eq_type[number]) == int(mj.mjtEq.mjEQ_JOINT)
        if not (is_joint and master >= 0 and model.eq_active0[number]):
            return None
        constant, ratio, *bends = map(float, model.eq_data[number][:5])
        if any(bends) or not ratio:
            return None
        # MuJoCo counts from the positions in which the model is written.
        offset = self._zero(follower) + constant - ratio * self._zero(master)
        if follower in self.driven and master not in self.driven:
            return master, follower, 1 / ratio, -offset / ratio
        return follower, master, ratio, offset


class _Writer:
    """The robot's XML.

    Attributes:
        robot: the root.
        meshes: numbers of the meshes that are used, by their files' names.
    """

    def __init__(self, model: _Mjcf, name: str) -> None:
        self._model, self._name = model, name
        self.robot = Element("robot", name=name)
        self.meshes: dict[str, int] = {}
        SubElement(self.robot, "link", name="world")
        for body in model.bodies():
            self._add_body(body)
        for site in range(model.compiled.nsite):
            self._add_site(site)

    def _add_body(self, body: int) -> None:
        model, name = self._model, self._model.links[body]
        parent, placement, anchor = model.parent(body), model.placement(body), np.zeros(3)
        joints = model.joints(body)
        for number, joint in enumerate(joints):
            # A slide goes along a line, wherever that is.
            next_anchor = anchor if joint.slides else joint.anchor
            at_zero = (
                _moved(-joint.zero * joint.axis)
                if joint.slides
                else _turned(joint.axis, -joint.zero)
            )
            origin = placement.then(_moved(next_anchor - anchor)).then(at_zero)
            is_last = number == len(joints) - 1 and not next_anchor.any()
            child = name if is_last else f"{name}_{number + 1}"
            self._add_joint(joint, parent, child, origin)
            if not is_last:
                self._add_light_link(child)
            parent, placement, anchor = child, _moved(np.zeros(3)), next_anchor
        if not joints or anchor.any():
            self._fix(f"{name}_fixed", parent, name, placement.then(_moved(-anchor)))
        link = SubElement(self.robot, "link", name=name)
        self._add_inertial(link, body)
        self._add_geoms(link, body)

    def _add_site(self, site: int) -> None:
        model = self._model.compiled
        body, name = int(model.site_bodyid[site]), self._model.sites[site]
        if int(model.body_rootid[body]) in self._model.left_out:
            return
        placement = _placed(model.site_pos[site], model.site_quat[site])
        self._fix(f"{name}_fixed", self._model.links[body], name, placement)
        self._add_light_link(name)

    def _add_joint(self, joint: _Joint, parent: str, child: str, origin: _Turn) -> None:
        model, number = self._model.compiled, joint.number
        limited = bool(model.jnt_limited[number])
        kind = "prismatic" if joint.slides else "revolute" if limited else "continuous"
        element = SubElement(self.robot, "joint", name=joint.name, type=kind)
        _add_origin(element, origin)
        SubElement(element, "parent", link=parent)
        SubElement(element, "child", link=child)
        SubElement(element, "axis", xyz=_numbers(joint.axis))
        # MJCF bounds no velocity, and 0 leaves it open.
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
        """Damping of a joint; its first coefficient where MuJoCo has several."""
        return float(np.ravel(self._model.compiled.dof_damping[row])[0])

    def _fix(self, name: str, parent: str, child: str, origin: _Turn) -> None:
        element = SubElement(self.robot, "joint", name=name, type="fixed")
        _add_origin(element, origin)
        SubElement(element, "parent", link=parent)
        SubElement(element, "child", link=child)

    def _add_light_link(self, name: str) -> None:
        link = SubElement(self.robot, "link", name=name)
        _add_mass(link, _moved(np.zeros(3)), LEAST_MASS, [LEAST_INERTIA] * 3)

    def _add_inertial(self, link: Element, body: int) -> None:
        model = self._model.compiled
        mass = float(model.body_mass[body])
        if mass == 0.0:
            _add_mass(link, _moved(np.zeros(3)), LEAST_MASS, [LEAST_INERTIA] * 3)
            return
        place = _placed(model.body_ipos[body], model.body_iquat[body])
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
                        _add_color(element, _color(model, geom), f"geom_{geom}")

    def _shapes(self, geom: int) -> list[tuple[_Turn, str, dict[str, str]]]:
        """The shapes of URDF that make up a geom: their placements, kinds and sizes."""
        model = self._model.compiled
        place = _placed(model.geom_pos[geom], model.geom_quat[geom])
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
            # URDF has none, but its parts.
            ends = [place.then(_moved([0.0, 0.0, end])) for end in (-size[1], size[1])]
            tube = (place, "cylinder", {"radius": radius, "length": height})
            return [tube, *((end, "sphere", {"radius": radius}) for end in ends)]
        if kind == "mesh":
            return [(place, "mesh", {"filename": self._mesh(int(model.geom_dataid[geom]))})]
        return []

    def _mesh(self, mesh: int) -> str:
        """The file of a mesh, which is written once however many geoms have it."""
        plain = re.sub(r"[^\w.-]+", "_", self._model.compiled.mesh(mesh).name, flags=re.ASCII)
        file = f"{self._name}_meshes/{plain or mesh}.stl"
        if self.meshes.get(file, mesh) != mesh:
            file = f"{self._name}_meshes/{plain}_{mesh}.stl"
        self.meshes[file] = mesh
        return file


def _uses(model: Any, geom: int) -> list[str]:
    """Whether a geom is seen, touched or both.

    The groups from 3 on are by convention those of shapes for contacts.
    """
    hidden = int(model.geom_group[geom]) >= _HIDDEN_GROUP or _color(model, geom)[3] == 0.0
    touches = bool(model.geom_contype[geom] or model.geom_conaffinity[geom])
    return [
        *([] if hidden else ["visual"]),
        *(["collision"] if touches or hidden else []),
    ]


def _color(model: Any, geom: int) -> list[float]:
    """Red, green, blue and opacity of a geom, of its material where it has one."""
    material = int(model.geom_matid[geom])
    rgba = model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]
    return [float(each) for each in rgba]


def _add_color(visual: Element, rgba: list[float], name: str) -> None:
    material = SubElement(visual, "material", name=name)
    SubElement(material, "color", rgba=" ".join(f"{each:.4g}" for each in rgba))


def _add_mass(link: Element, place: _Turn, mass: float, moments: list[float]) -> None:
    """Mass and principal moments of inertia, about the axes of a placement."""
    inertial = SubElement(link, "inertial")
    _add_origin(inertial, place)
    SubElement(inertial, "mass", value=_number(mass))
    xx, yy, zz = map(_number, moments)
    SubElement(inertial, "inertia", ixx=xx, iyy=yy, izz=zz, ixy="0", ixz="0", iyz="0")


def _add_origin(element: Element, place: _Turn) -> None:
    SubElement(element, "origin", xyz=_numbers(place.position), rpy=_numbers(_rpy(place.rotation)))


def _rpy(rotation: Floats) -> tuple[float, float, float]:
    """Turns about the fixed x, then y, then z axis, rad.

    The roll is what yaw and pitch leave over: together they are exact at a pitch of 90 deg, too.
    """
    r = rotation
    yaw = math.atan2(r[1, 0], r[0, 0]) if math.hypot(r[0, 0], r[1, 0]) > 1e-12 else 0.0
    c, s = math.cos(yaw), math.sin(yaw)
    pitch = math.atan2(-r[2, 0], c * r[0, 0] + s * r[1, 0])
    roll = math.atan2(s * r[0, 2] - c * r[1, 2], c * r[1, 1] - s * r[0, 1])
    return roll, pitch, yaw


def _number(value: float) -> str:
    # Without a minus before nothing.
    return f"{float(value) + 0.0:.17g}"


def _numbers(values: Iterable[float]) -> str:
    return " ".join(map(_number, values))


def _distinct(name: str, taken: set[str]) -> str:
    number, distinct = 2, name
    while distinct in taken:
        distinct, number = f"{name}_{number}", number + 1
    taken.add(distinct)
    return distinct


def _remark(names: list[str], trait: str) -> Iterator[str]:
    """A sentence about parts that share a trait; nothing without any."""
    if not names:
        return
    if len(names) == 1:
        yield f"'{names[0]}' {trait}"
    else:
        yield f"each of {', '.join(repr(name) for name in names)} {trait}"
