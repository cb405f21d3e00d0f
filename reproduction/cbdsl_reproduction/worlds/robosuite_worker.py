"""Simulation of robosuite, in the Python environment of robosuite.

``RobosuiteProcess`` starts this file; it imports nothing of cbdsl. Standard input has one JSON
document a line: first the arguments of ``RobosuiteWorld``, then requests with the key ``do``. Each
answer is a line of JSON and, after it, the bytes of its images, whose number ``bytes`` states.
"""

from __future__ import annotations

import json
import os
import sys
import xml.etree.ElementTree as ET
from typing import Any, BinaryIO

import mujoco
import numpy as np
import robosuite
from robosuite.controllers import load_composite_controller_config

# Time for which a gripper is opened or closed to measure the coupling of its joints, s.
_STROKE = 1.5
# Servos of the arms: gain, 1/s^2, and damping ratio; the largest gain that robosuite allows.
_GAIN, _DAMPING = 300.0, 1.0
_GRAVITY = 9.81  # m/s^2
# Thickness of a shell by which one of two equal surfaces covers the other, m.
_SHELL = 3e-4
_TIP_SITE = "grip_site"
# Name of the only arm of a robot.
_SIDE = "right"
_ROBOT_PREFIXES = ("robot", "gripper", "fixed_mount")
# Groups of geoms: those of robosuite for contacts and for images, and the robots' own of both. The
# meshes of robots have 100,000 triangles; their outlines are those of the shapes for contacts.
_CONTACTS, _IMAGES, _SURFACES, _OUTLINES = 0, 1, 4, 5


class RobosuiteWorld:
    """One task of robosuite with one arm, or with several.

    Args:
        task: Name of the environment.
        arms: Names of the robots.
        rate: Control rate, Hz.
        cameras: Position and orientation (xyz axes by columns) of the cameras, by name.
        view: Width and height of an image, px, and vertical angle of view, deg.
    """

    def __init__(
        self,
        task: str,
        arms: list[str],
        rate: float,
        cameras: dict[str, dict[str, list[float]]],
        view: tuple[int, int, float],
    ) -> None:
        self._task, self._arms, self._rate = task, arms, rate
        self._cameras, self._view = cameras, view
        self._env: Any = None
        self._renderer: mujoco.Renderer | None = None
        self._owners: Any = None

    def reset(self, seed: int) -> None:
        """Make the environment anew, so that equal seeds give equal episodes."""
        self.close()
        self._env = robosuite.make(
            self._task,
            robots=self._arms,
            controller_configs=[_servos(arm) for arm in self._arms],
            has_renderer=False,
            has_offscreen_renderer=False,
            use_camera_obs=False,
            control_freq=self._rate,
            ignore_done=True,
            seed=seed,
        )
        self._env.set_xml_processor(self._with_cameras)
        self._env.reset()
        self._robot_bodies = {
            index
            for index in range(self.model.nbody)
            if self.model.body(index).name.startswith(_ROBOT_PREFIXES)
        }
        for geom, body in enumerate(self.model.geom_bodyid):
            if body in self._robot_bodies:
                own = {_CONTACTS: _OUTLINES, _IMAGES: _SURFACES}
                group = int(self.model.geom_group[geom])
                self.model.geom_group[geom] = own.get(group, group)
        self._hands = [SharedGripper(robot) for robot in self._env.robots]

    def close(self) -> None:
        """Free the environment and its renderer."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = self._owners = None
        if self._env is not None:
            self._env.close()
            self._env = None

    @property
    def model(self) -> Any:
        """Model of MuJoCo."""
        return self._env.sim.model._model

    @property
    def data(self) -> Any:
        """State of MuJoCo."""
        return self._env.sim.data._data

    def step(self, arms: list[list[float]], closing: list[float]) -> None:
        """Let one control period pass.

        Args:
            arms: References of the joints of each arm, rad, shape (n,).
            closing: Reference of each hand, from 0 (open) to 1 (closed).
        """
        actions = []
        for hand, arm, share in zip(self._hands, arms, closing, strict=True):
            hand.share = share
            parts = {_SIDE: np.array(arm), hand.part: np.zeros(hand.gripper.dof)}
            actions.append(hand.robot.create_action_vector(parts))
        self._env.step(np.concatenate(actions))

    def success(self) -> bool:
        """Return the verdict of the task's own test."""
        return bool(self._env._check_success())

    def read(self, joints: list[str], cells: list[str]) -> dict[str, Any]:
        """Return the measurements of encoders and load cells, and the verdict of the task.

        Args:
            joints: Names of the joints.
            cells: Bodies with load cells.
        """
        model, data = self.model, self.data
        places = [model.joint(name) for name in joints]
        return {
            "positions": [float(data.qpos[each.qposadr[0]]) for each in places],
            "velocities": [float(data.qvel[each.dofadr[0]]) for each in places],
            "wrenches": self._wrenches([model.body(name).id for name in cells]),
            "success": self.success(),
        }

    def _wrenches(self, cells: list[int]) -> list[list[float]]:
        """Return the wrenches of load cells at the origins of bodies, world axes, shape (n, 6).

        It is the wrench of the contacts on the world and on other cells, and the weight of the
        body. Forces between the parts of a closed chain are none of the measured ones.
        """
        model, data = self.model, self.data
        totals, single = np.zeros((len(cells), 6)), np.zeros(6)
        for total, body in zip(totals, cells, strict=True):
            total[2] = _GRAVITY * model.body_mass[body]
            total[3:] = np.cross(data.xipos[body] - data.xpos[body], total[:3])
        for index in range(data.ncon):
            contact = data.contact[index]
            bodies = [int(model.geom_bodyid[geom]) for geom in contact.geom]
            if not any(body in cells for body in bodies) or any(
                body in self._robot_bodies and body not in cells for body in bodies
            ):
                continue
            mujoco.mj_contactForce(model, data, index, single)
            # The force of the first geom on the second, in the frame of the contact.
            force = contact.frame.reshape(3, 3).T @ single[:3]
            for sign, body in zip((1.0, -1.0), bodies, strict=True):
                if body in cells:
                    total = totals[cells.index(body)]
                    total[:3] += sign * force
                    total[3:] += np.cross(contact.pos - data.xpos[body], sign * force)
        return totals.tolist()

    def label(self, features: dict[str, list[str]]) -> bytes:
        """Return an image for each camera: the number of the feature of each pixel, from 1.

        Args:
            features: Names of bodies or geoms by feature; bodies that they carry belong to them.
        """
        renderer = self._ready_renderer()
        if self._owners is None:
            self._owners = self._features_of_geoms(features)
        renderer.enable_segmentation_rendering()
        images = []
        for camera in self._cameras:
            renderer.update_scene(self.data, camera, _shown(_OUTLINES))
            seen = renderer.render()
            is_geom = seen[..., 1] == int(mujoco.mjtObj.mjOBJ_GEOM)
            labels = np.where(is_geom, self._owners[seen[..., 0]], 0)
            images.append(labels.astype(np.uint8).tobytes())
        renderer.disable_segmentation_rendering()
        return b"".join(images)

    def _features_of_geoms(self, features: dict[str, list[str]]) -> Any:
        owners = np.zeros(self.model.ngeom + 1, np.uint8)
        lines = [
            self._line(body) | {self.model.geom(geom).name}
            for geom, body in enumerate(self.model.geom_bodyid)
        ]
        for number, bodies in enumerate(features.values(), start=1):
            for geom, line in enumerate(lines):
                if line & set(bodies):
                    owners[geom] = number
        # Parts of a thing may share surfaces: those of the first feature are seen.
        for name in next(iter(features.values())):
            for geom in range(self.model.ngeom):
                if self.model.geom(geom).name == name and self.model.geom_contype[geom] == 0:
                    self.model.geom_size[geom] += _SHELL
        return owners

    def render(self) -> bytes:
        """Return the RGB image of each camera."""
        renderer = self._ready_renderer()
        images = []
        for camera in self._cameras:
            renderer.update_scene(self.data, camera, _shown(_SURFACES))
            images.append(renderer.render().tobytes())
        return b"".join(images)

    def _line(self, body: int) -> set[str]:
        """Return the names of a body and of the bodies that carry it."""
        names = set()
        while body:
            names.add(self.model.body(body).name)
            body = self.model.body_parentid[body]
        return names

    def _ready_renderer(self) -> mujoco.Renderer:
        if self._renderer is None:
            width, height, _ = self._view
            self.model.vis.quality.offsamples = 0
            self._renderer = mujoco.Renderer(self.model, height, width)
            # Lights move no outline, and take most of the time.
            for flag in (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION):
                self._renderer.scene.flags[flag] = 0
        return self._renderer

    def _with_cameras(self, text: str) -> str:
        """Return the scene with the cameras of the robot."""
        root = ET.fromstring(text)
        for name, place in self._cameras.items():
            # MuJoCo's cameras look along -z with y up; the link's x looks forward, with z up.
            axes = np.reshape(place["axes"], (3, 3))
            camera = ET.SubElement(_section(root, "worldbody"), "camera", name=name, mode="fixed")
            camera.set("pos", _text(place["position"]))
            camera.set("xyaxes", _text([*-axes[:, 1], *axes[:, 2]]))
            camera.set("fovy", str(self._view[2]))
        # MuJoCo ignores contacts between neighbours, except next to a fixed body: there they brake
        # the first joint of an arm.
        for parent in root.iter("body"):
            for child in parent.findall("body"):
                names = {"body1": parent.get("name", ""), "body2": child.get("name", "")}
                if all(name.startswith(_ROBOT_PREFIXES) for name in names.values()):
                    ET.SubElement(_section(root, "contact"), "exclude", names)
        return ET.tostring(root, encoding="unicode")

    def robot_model(self) -> str:
        """Return the arms alone as MJCF, with their hands' measured couplings and the cameras.

        The closed chains and tendons of a gripper are replaced by couplings of joints: each joint
        follows one with an actuator, as in a gripper that closes on nothing.
        """
        root, *others = (ET.fromstring(hand.robot.robot_model.get_xml()) for hand in self._hands)
        for other in others:
            for section in other:
                _section(root, section.tag).extend(section)
        for name in ("sensor", "tendon", "equality", "keyframe"):
            for section in root.findall(name):
                root.remove(section)
        _keep_tips(root)
        for leader, followers in self.couplings():
            self._couple(root, leader, followers)
        for name, place in self._cameras.items():
            axes = np.reshape(place["axes"], (3, 3))
            body = ET.SubElement(_section(root, "worldbody"), "body", name=f"{name}_camera")
            body.set("pos", _text(place["position"]))
            body.set("xyaxes", _text([*axes[:, 0], *axes[:, 1]]))
        return ET.tostring(root, encoding="unicode")

    def _couple(self, root: ET.Element, leader: Stroke, followers: list[Stroke]) -> None:
        """Replace the actuators of the hands by a leading joint and couplings."""
        actuators = _section(root, "actuator")
        replaced = {name for hand in self._hands for name in hand.gripper.actuators}
        for actuator in list(actuators):
            if actuator.get("name") in replaced:
                actuators.remove(actuator)
        for joint in root.iter("joint"):
            if joint.get("name") == leader.name:
                joint.set("range", _text(sorted((leader.open, leader.closed))))
                joint.set("limited", "true")
        ET.SubElement(actuators, "position", name=f"{leader.name}_servo", joint=leader.name)
        for follower in followers:
            ratio = (follower.closed - follower.open) / (leader.closed - leader.open)
            # MuJoCo measures both positions from the model's first posture.
            start = follower.open - ratio * leader.open
            first = follower.first - ratio * leader.first
            coupling = ET.SubElement(_section(root, "equality"), "joint", joint1=follower.name)
            coupling.set("joint2", leader.name)
            coupling.set("polycoef", f"{start - first:.9g} {ratio:.9g} 0 0 0")

    def couplings(self) -> list[tuple[Stroke, list[Stroke]]]:
        """Open and close the hands; return the leading joint of each and its followers."""
        ends = []
        for share in (0.0, 1.0):
            for _ in range(round(_STROKE * self._rate)):
                still = [hand.robot._joint_positions for hand in self._hands]
                self.step(still, [share] * len(self._hands))
            ends.append(self.data.qpos.copy())
        return [self._coupling(hand.gripper, *ends) for hand in self._hands]

    def _coupling(self, gripper: Any, opened: Any, closed: Any) -> tuple[Stroke, list[Stroke]]:
        rows = []
        for name in gripper.joints:
            place = self.model.joint(name).qposadr[0]
            ends = self.model.qpos0[place], opened[place], closed[place]
            rows.append(Stroke(name, *(float(end) for end in ends)))
        driven = [
            self.model.joint(int(self.model.actuator(name).trnid[0])).name
            for name in gripper.actuators
            if self.model.actuator(name).trntype[0] == mujoco.mjtTrn.mjTRN_JOINT
        ]
        leaders = [row for row in rows if row.name in driven] or rows
        leader = max(leaders, key=lambda row: abs(row.closed - row.open))
        return leader, [row for row in rows if row is not leader]


class Stroke:
    """Positions of a joint of a hand, rad or m: in the model's first posture, open and closed."""

    def __init__(self, name: str, first: float, open_: float, closed: float) -> None:
        self.name, self.first, self.open, self.closed = name, first, open_, closed


class SharedGripper:
    """Gripper that is set by a share of its stroke, through its own actuators.

    Args:
        robot: Robot of robosuite.

    Attributes:
        robot: The robot.
        gripper: Gripper of robosuite.
        part: Name of its part in an action.
        share: Reference, from 0 (open) to 1 (closed).
    """

    def __init__(self, robot: Any) -> None:
        self.robot, self.gripper = robot, robot.gripper[_SIDE]
        self.part, self.share = robot.get_gripper_name(_SIDE), 0.0
        closed, opened = (self._end(sign) for sign in (1.0, -1.0))
        self.gripper.format_action = lambda _: opened + self.share * (closed - opened)

    def _end(self, sign: float) -> Any:
        """Return the actuators' references after a long way in one direction."""
        for _ in range(1000):
            reference = self.gripper.format_action(np.full(self.gripper.dof, sign))
        return np.array(reference, dtype=float)


def _servos(arm: str) -> dict[str, Any]:
    """Return the configuration of an arm's controllers: servos of its joints."""
    config: dict[str, Any] = load_composite_controller_config(controller="BASIC", robot=arm)
    config["body_parts"][_SIDE].update(
        type="JOINT_POSITION",
        input_type="absolute",
        kp=_GAIN,
        damping_ratio=_DAMPING,
        output_max=1,
        output_min=-1,
        interpolation="linear",
        ramp_ratio=1.0,
    )
    return config


def _section(root: ET.Element, name: str) -> ET.Element:
    """Return a section of a model, which is added if it is missing."""
    section = root.find(name)
    return ET.SubElement(root, name) if section is None else section


def _keep_tips(root: ET.Element) -> None:
    """Remove the decorating sites; the site between the fingers gets the usual name of a tip."""
    for parent in root.iter():
        for site in parent.findall("site"):
            name = site.get("name", "")
            if name.endswith(_TIP_SITE):
                site.set("name", name.removesuffix(_TIP_SITE) + "tcp")
            else:
                parent.remove(site)


def _shown(group: int) -> mujoco.MjvOption:
    """Return the option to show the scene, and the robots' geoms of a group."""
    option = mujoco.MjvOption()
    option.geomgroup[:] = 0
    option.geomgroup[[_IMAGES, group]] = 1
    return option


def _text(values: Any) -> str:
    return " ".join(f"{value:.9g}" for value in values)


def answer(world: RobosuiteWorld, request: dict[str, Any]) -> tuple[dict[str, Any], bytes]:
    """Return the answer to a request, and the bytes of its images."""
    match request["do"]:
        case "reset":
            world.reset(request["seed"])
            return {}, b""
        case "model":
            return {"xml": world.robot_model()}, b""
        case "step":
            world.step(request["arms"], request["closing"])
            return {}, b""
        case "read":
            images = b""
            if request.get("label"):
                images = world.label(request["label"])
            elif request.get("render"):
                images = world.render()
            return world.read(request["joints"], request["cells"]), images
    raise ValueError(f"unknown request {request['do']!r}")


def main(answers: BinaryIO) -> None:
    """Answer requests until standard input ends; the first one opens the world."""
    world = RobosuiteWorld(**json.loads(sys.stdin.readline()))
    for line in sys.stdin:
        images = b""
        try:
            reply, images = answer(world, json.loads(line))
        except Exception as error:
            reply = {"error": f"{type(error).__name__}: {error}"}
        reply["bytes"] = len(images)
        answers.write(json.dumps(reply).encode() + b"\n" + images)
        answers.flush()
    world.close()


if __name__ == "__main__":
    # Messages of robosuite go to standard error, so that answers stay apart from them.
    channel = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    main(channel)
