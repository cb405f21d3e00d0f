"""MJCF models compiled by MuJoCo, with the names and terms of URDF."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import mujoco as mj
import numpy as np

from cbdsl.extend.backend import Floats
from cbdsl.extend.model import UrdfError
from cbdsl_formats.mjcf.body_frame import BodyFrame, placed

# Gravity of stages, and the largest difference without a remark, m/s^2.
_GRAVITY, _GRAVITY_TOLERANCE = 9.81, 0.05


class MjcfJoint(NamedTuple):
    """Hinge or slide of the model, in terms of URDF.

    Attributes:
        number: Number in the compiled model.
        name: Name in the URDF.
        slides: True for a slide.
        zero: Position at which the bodies are placed as in the model file, rad or m.
        anchor, axis: Anchor, m, and axis in the body's frame, shape (3,).
        mimic: Followed joint, with multiplier and offset, if any.
    """

    number: int
    name: str
    slides: bool
    zero: float
    anchor: Floats
    axis: Floats
    mimic: tuple[str, float, float] | None


class MjcfModel:
    """Compiled model with the names and terms of URDF.

    Args:
        path: Path of the model, for messages.
        compiled: Compiled model of MuJoCo.

    Raises:
        UrdfError: If one of its joints is a ball joint.
    """

    def __init__(self, path: Path, compiled: Any) -> None:
        self.path, self.compiled = path, compiled
        names: set[str] = {"world"}
        self.links = ["world"] + [
            distinct(compiled.body(body).name or f"body_{body}", names)
            for body in range(1, compiled.nbody)
        ]
        self.sites = [
            distinct(compiled.site(site).name or f"site_{site}", names)
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
        """Return the bodies that belong to the robot, each after its parent."""
        model = self.compiled
        return [
            body
            for body in range(1, model.nbody)
            if int(model.body_rootid[body]) not in self.left_out
        ]

    def parent(self, body: int) -> str:
        """Return the link that carries a body."""
        return self.links[int(self.compiled.body_parentid[body])]

    def placement(self, body: int) -> BodyFrame:
        """Return a body's frame in its parent's, with all joints as in the file."""
        return placed(self.compiled.body_pos[body], self.compiled.body_quat[body])

    def joints(self, body: int) -> list[MjcfJoint]:
        """Return the hinges and slides of a body, in the order in which they move it."""
        model = self.compiled
        first, many = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        numbers = [n for n in range(first, first + many) if self._kind(n) != "free"]
        return [
            MjcfJoint(
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
        """Return the largest torque or force of a joint's actuators, N m or N; 0 if unlimited."""
        model = self.compiled
        most = sum(self._force(each) for each in self.driven.get(joint, ()))
        if model.jnt_actfrclimited[joint]:
            bound = float(np.abs(model.jnt_actfrcrange[joint]).max())
            # The sum is 0 for a joint without actuators, which must not count as the smaller bound.
            most = min(most or math.inf, bound)
        return most if math.isfinite(most) else 0.0

    def stl(self, mesh: int) -> bytes:
        """Return a mesh as binary STL, in MuJoCo's frame of the mesh."""
        model = self.compiled
        return stl_of(model_corners(model, mesh))

    def remarks(self) -> Iterator[str]:
        """Yield sentences about parts that have no counterpart in URDF."""
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
            plural = "s" if scenery > 1 else ""
            yield f"left out {scenery} geom{plural} of the world, which belong on a stage"
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
            distinct(self.compiled.joint(n).name or f"{self.links[self._body(n)]}_joint", names)
            for n in range(self.compiled.njnt)
        ]

    def _is_thing(self, body: int) -> bool:
        """Return whether a body is an object beside the robot: mocap, or only with a free joint."""
        model = self.compiled
        if int(model.body_parentid[body]) != 0:
            return False
        if model.body_mocapid[body] >= 0:
            return True
        own = [n for n in range(model.njnt) if model.body_rootid[self._body(n)] == body]
        # A free joint alone does not make an object: the robot itself may float, as a quadruped
        # does. It then has further joints, or is the only tree of the model with any.
        others = any(model.body_rootid[self._body(n)] != body for n in range(model.njnt))
        return others and [self._kind(n) for n in own] == ["free"]

    def _acts_on_joint(self, actuator: int) -> bool:
        kinds = (mj.mjtTrn.mjTRN_JOINT, mj.mjtTrn.mjTRN_JOINTINPARENT)
        return int(self.compiled.actuator_trntype[actuator]) in map(int, kinds)

    def _driven(self) -> dict[int, list[int]]:
        """Return the actuators by their joint."""
        driven: dict[int, list[int]] = {}
        for actuator in range(self.compiled.nu):
            if self._acts_on_joint(actuator):
                joint = int(self.compiled.actuator_trnid[actuator, 0])
                driven.setdefault(joint, []).append(actuator)
        return driven

    def _force(self, actuator: int) -> float:
        """Return the largest force of an actuator on its joint; infinite without a bound."""
        model = self.compiled
        gear = abs(float(model.actuator_gear[actuator, 0]))
        if model.actuator_forcelimited[actuator]:
            return gear * float(np.abs(model.actuator_forcerange[actuator]).max())
        # A plain motor exerts gear * gain * control, which a limited control bounds. Other
        # actuators, such as servos, add a bias that depends on the state, so that the range of
        # control does not bound their force.
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
        """Return joints that an equality makes proportional to another, by their number."""
        model = self.compiled
        mimics: dict[int, tuple[str, float, float]] = {}
        for number in range(model.neq):
            pair = self._proportional(number)
            # A joint can follow only one other joint, which must not be a follower already.
            if pair is None or pair[0] in mimics or pair[1] in mimics:
                self.unmatched_equalities.append(model.equality(number).name or f"number {number}")
                continue
            follower, master, ratio, offset = pair
            mimics[follower] = (self.joint_names[master], ratio, offset)
        return mimics

    def _proportional(self, number: int) -> tuple[int, int, float, float] | None:
        """Return follower, leader, multiplier and offset of an equality, if it is linear."""
        model = self.compiled
        follower, master = int(model.eq_obj1id[number]), int(model.eq_obj2id[number])
        is_joint = int(model.eq_type[number]) == int(mj.mjtEq.mjEQ_JOINT)
        if not (is_joint and master >= 0 and model.eq_active0[number]):
            return None
        constant, ratio, *bends = map(float, model.eq_data[number][:5])
        if any(bends) or not ratio:
            return None
        # MuJoCo constrains y - y0 = a0 + a1 (x - x0) + a2 (x - x0)^2 + ..., with x0 and y0 from
        # qpos0. The mimic of URDF is y = ratio x + offset, so that only a linear equality has a
        # counterpart. If the actuator drives y, the equation is solved for x.
        # MuJoCo measures from the positions in the model file.
        offset = self._zero(follower) + constant - ratio * self._zero(master)
        if follower in self.driven and master not in self.driven:
            return master, follower, 1 / ratio, -offset / ratio
        return follower, master, ratio, offset


def model_corners(model: Any, mesh: int) -> Floats:
    """Return the corners of the triangles of a compiled model's mesh, m, shape (n, 3, 3)."""
    start, many = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    corners = model.mesh_vert[start : start + many]
    start, many = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    return np.asarray(corners[model.mesh_face[start : start + many]], dtype=np.float64)


def stl_of(corners: Floats) -> bytes:
    """Return triangles, shape (n, 3, 3), as binary STL."""
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("unused", "<u2")])
    triangles = np.zeros(len(corners), dtype=record)
    triangles["corners"] = corners
    return bytes(80) + len(corners).to_bytes(4, "little") + bytes(triangles.tobytes())


def distinct(name: str, taken: set[str]) -> str:
    """Return a name, with a number if it is taken, and take it."""
    number, distinct = 2, name
    while distinct in taken:
        distinct, number = f"{name}_{number}", number + 1
    taken.add(distinct)
    return distinct


def _remark(names: list[str], trait: str) -> Iterator[str]:
    """Yield a sentence about parts that share a trait, if there are any."""
    if not names:
        return
    if len(names) == 1:
        yield f"'{names[0]}' {trait}"
    else:
        yield f"each of {', '.join(repr(name) for name in names)} {trait}"
