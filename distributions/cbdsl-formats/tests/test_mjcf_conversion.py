"""MJCF converted to URDF: where MuJoCo has bodies and sites, kinematics of the URDF has links."""

from __future__ import annotations

import struct
from pathlib import Path

import gymnasium
import mujoco
import numpy as np
import pinocchio
import pytest

from cbdsl.extend.model import ConvertedModel
from cbdsl.robot.urdf import UrdfError, UrdfModel
from cbdsl.robot.urdf_reader import parse_urdf
from cbdsl_formats.mjcf.conversion import LEAST_MASS, convert_mjcf

ASSETS = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets"
SEED = 5_250_000

# Anchors off the origin, a reference, several joints a body, a slide between hinges, turned frames.
ODD = """
<mujoco>
  <compiler angle="degree" autolimits="true"/>
  <asset><mesh name="wedge" file="wedge.stl" scale="2 1 1"/></asset>
  <default><default class="drive"><joint damping="3" frictionloss="0.2"/></default></default>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 1"/>
    <body name="base" pos="0.1 0.2 0.3" euler="10 90 30">
      <geom type="box" size="0.1 0.2 0.3" rgba="1 0 0 1"/>
      <body name="one" pos="0 0.1 0.2" euler="0 90 0">
        <joint name="a" class="drive" axis="1 2 3" pos="0.03 0.02 0.01" range="-90 60"/>
        <joint name="b" type="slide" axis="0 1 1" ref="0.05" range="-0.1 0.2"/>
        <joint name="c" axis="0 1 0" pos="0 0.05 0" ref="20"/>
        <inertial pos="0.01 0.02 0.03" mass="2" fullinertia="0.03 0.04 0.05 0.001 0.002 0.003"/>
        <geom type="capsule" size="0.02 0.1" contype="0" conaffinity="0"/>
        <geom type="ellipsoid" name="egg" size="0.1 0.2 0.3"/>
        <site name="flange" pos="0.1 0 0.2" euler="30 40 50"/>
        <body name="two" pos="0.3 0 0">
          <joint name="d" range="-180 180" axis="0 0 1"/>
          <geom type="mesh" mesh="wedge" pos="0.1 0 0" euler="0 0 45" group="3"/>
          <geom type="cylinder" size="0.02 0.1"/><geom type="sphere" size="0.02"/>
        </body>
        <body name="three"><joint name="e" type="slide" range="0 0.04"/><geom size="0.01"/></body>
        <body name="four"><joint name="f" type="slide" range="0 0.04"/><geom size="0.01"/></body>
      </body>
    </body>
    <body name="cube"><freejoint name="loose"/><geom type="box" size="0.1 0.1 0.1"/></body>
  </worldbody>
  <equality><joint joint1="e" joint2="f" polycoef="0 1 0 0 0"/>
    <connect name="loop" body1="two" body2="base" anchor="0 0 0"/></equality>
  <actuator>
    <motor joint="a" gear="50" ctrlrange="-2 2"/>
    <position joint="d" kp="100" forcerange="-12 15"/>
    <motor joint="e" ctrlrange="-1 1"/>
  </actuator>
</mujoco>
"""


@pytest.fixture
def odd(tmp_path: Path) -> Path:
    corners = [(0, 0, 0), (0.05, 0, 0), (0, 0.05, 0), (0, 0, 0.05)]
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    rows = [
        struct.pack("<12fH", 0, 0, 0, *corners[a], *corners[b], *corners[c], 0) for a, b, c in faces
    ]
    (tmp_path / "wedge.stl").write_bytes(bytes(80) + struct.pack("<I", 4) + b"".join(rows))
    path = tmp_path / "odd.xml"
    path.write_text(ODD)
    return path


def urdf_of(conversion: ConvertedModel) -> UrdfModel:
    return parse_urdf(conversion.text, Path("odd.urdf"))


def farthest(path: Path, conversion: ConvertedModel, postures: int = 100) -> float:
    """Return the largest difference of placements between MuJoCo and the URDF."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data, rng = mujoco.MjData(model), np.random.default_rng(SEED)
    copy = pinocchio.buildModelFromXML(conversion.text)
    copied, compared, worst = copy.createData(), set(), 0.0
    for _ in range(postures):
        q = pinocchio.neutral(copy)
        for number in range(model.njnt):
            name = model.joint(number).name
            if not copy.existJointName(name):
                continue
            bounds = model.jnt_range[number] if model.jnt_limited[number] else (-3, 3)
            angle = rng.uniform(*bounds)
            data.qpos[model.jnt_qposadr[number]] = angle
            joint = copy.joints[copy.getJointId(name)]
            own = [angle] if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
            q[joint.idx_q : joint.idx_q + joint.nq] = own
        mujoco.mj_kinematics(model, data)
        pinocchio.framesForwardKinematics(copy, copied, q)
        places = [(model.body(n).name, data.xpos[n], data.xmat[n]) for n in range(1, model.nbody)]
        places += [
            (model.site(n).name, data.site_xpos[n], data.site_xmat[n]) for n in range(model.nsite)
        ]
        for name, position, rotation in places:
            if name and copy.existFrame(name):
                compared.add(name)
                frame = copied.oMf[copy.getFrameId(name)]
                worst = max(worst, np.abs(frame.translation - position).max())
                worst = max(worst, np.abs(frame.rotation - rotation.reshape(3, 3)).max())
    assert len(compared) >= 3
    return worst


@pytest.mark.parametrize("name", ["pusher_v5", "reacher", "humanoid", "ant", "walker2d_v5"])
def test_public_models_are_placed_as_by_mujoco(name: str) -> None:
    path = ASSETS / f"{name}.xml"
    assert farthest(path, convert_mjcf(path, "r")) < 1e-9


def test_every_oddity_of_joints_is_placed_as_by_mujoco(odd: Path) -> None:
    assert farthest(odd, convert_mjcf(odd, "odd")) < 1e-9


def test_masses_and_inertias_are_mujocos(odd: Path) -> None:
    bodies = urdf_of(convert_mjcf(odd, "odd")).bodies
    model = mujoco.MjModel.from_xml_path(str(odd))
    for name in ("base", "one", "two", "three"):
        number, inertial = model.body(name).id, bodies[name].inertial
        assert inertial is not None
        assert inertial.mass == pytest.approx(model.body_mass[number], rel=1e-12)
        own, turned = np.zeros(9), np.array(inertial.origin.rotation)
        mujoco.mju_quat2Mat(own, model.body_iquat[number])
        own = own.reshape(3, 3)
        wanted = own @ np.diag(model.body_inertia[number]) @ own.T
        assert turned @ np.diag(inertial.inertia[:3]) @ turned.T == pytest.approx(wanted, abs=1e-12)
        assert inertial.origin.xyz == pytest.approx(tuple(model.body_ipos[number]), abs=1e-12)
    light = [body for name, body in bodies.items() if name in ("one_1", "one_2", "one_3", "flange")]
    assert len(light) == 4
    assert {body.inertial.mass for body in light if body.inertial} == {LEAST_MASS}


def test_limits_efforts_and_couplings_are_the_models(odd: Path) -> None:
    joints = urdf_of(convert_mjcf(odd, "odd")).joints
    assert joints["a"].effort == 100 and joints["d"].effort == 15
    assert (joints["a"].lower, joints["a"].upper) == pytest.approx((-np.pi / 2, np.pi / 3))
    assert joints["b"].kind == "prismatic" and joints["c"].kind == "continuous"
    # The joint with a motor is followed, in either order of the equality.
    assert joints["f"].mimic is not None and joints["e"].mimic is None
    assert tuple(joints["f"].mimic) == ("e", 1.0, 0.0)


def test_shapes_are_seen_and_touched_as_in_the_model(odd: Path) -> None:
    conversion = convert_mjcf(odd, "odd")
    bodies = urdf_of(conversion).bodies
    assert bodies["base"].visuals[0].size == (0.2, 0.4, 0.6)
    assert bodies["base"].visuals[0].color == (1, 0, 0)
    assert [shape.kind for shape in bodies["one"].visuals] == ["cylinder", "ball", "ball"]
    assert bodies["one"].collisions == ()
    assert [shape.kind for shape in bodies["two"].visuals] == ["cylinder", "ball"]
    assert [shape.kind for shape in bodies["two"].collisions] == ["mesh", "cylinder", "ball"]
    mesh = bodies["two"].collisions[0]
    triangles = np.frombuffer(
        conversion.meshes[mesh.file][84:],
        dtype=[("n", "<f4", 3), ("corners", "<f4", (3, 3)), ("unused", "<u2")],
    )["corners"]
    # The geom has the mesh's own origin: its corner is at 0, and the scaled corner at 0.1.
    corners = triangles.reshape(-1, 3) @ np.array(mesh.origin.rotation).T + mesh.origin.xyz
    half = 0.1 / np.sqrt(2)
    for corner in ([0.1, 0, 0], [0.1 + half, half, 0]):
        assert np.abs(corners - corner).max(axis=1).min() < 1e-6


def test_parts_without_a_counterpart_are_named(odd: Path) -> None:
    remarks = " ".join(convert_mjcf(odd, "odd").remarks)
    for name in ("'cube'", "'egg'", "'loop'", "1 geom of the world", "'b'", "'c'"):
        assert name in remarks
    assert "cube" not in urdf_of(convert_mjcf(odd, "odd")).links


def test_another_gravity_is_reported() -> None:
    assert any(
        "gravity is 0" in each for each in convert_mjcf(ASSETS / "pusher_v5.xml", "r").remarks
    )
    assert not any("gravity" in each for each in convert_mjcf(ASSETS / "ant.xml", "r").remarks)


_NAMED = '<mujoco><worldbody><body name="{}"><geom size="1"/></body></worldbody></mujoco>'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            '<mujoco><worldbody><body name="b"><joint name="s" type="ball"/><geom size="1"/>'
            "</body></worldbody></mujoco>",
            "joint 's' of body 'b' is a ball joint",
        ),
        ("<mujoco><worldbody><bdy/></worldbody></mujoco>", "MuJoCo cannot compile it"),
        (_NAMED.format("a\x05"), r"the control character '\\x05'"),
        (_NAMED.format("\u00e9").encode("latin-1"), "one of its names is not UTF-8"),
    ],
)
def test_models_that_cannot_be_converted_say_why(
    text: str | bytes, words: str, tmp_path: Path
) -> None:
    path = tmp_path / "m.xml"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    with pytest.raises(UrdfError, match=words):
        convert_mjcf(path, "m")
