"""Models of robots in the formats of the field, as ``cb new robot`` and documents read them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from cbdsl.robot.meshes.mesh_damage import _damage, mesh_damage
from cbdsl.robot.package_folders import PackageFolders
from cbdsl.robot.srdf import parse_srdf
from cbdsl.robot.urdf import UrdfError
from cbdsl.robot.urdf_reader import parse_urdf
from tests.conftest import ROOT
from tests.fuzz.entry_point import EntryPoint
from tests.fuzz.scratch import scratch
from tests.robot.meshes.samples import DAMAGED, SOUND

_FILE = Path("any.urdf")
_LARGEST = 8000
MESHES = (".stl", ".obj", ".dae", ".ply", ".glb", ".gltf", ".xyz")


def _urdf(data: bytes) -> None:
    try:
        model = parse_urdf(data, _FILE)
        assert len(model.bodies) == len(model.links)
    except UrdfError as error:
        assert "any.urdf" in str(error)


def _srdf(data: bytes) -> None:
    try:
        parse_srdf(data, _FILE)
    except UrdfError as error:
        assert "any.urdf" in str(error)


def _xacro(data: bytes) -> None:
    from cbdsl_formats.expansion import expand_xacro

    file = scratch() / "any.xacro"
    file.write_bytes(data)
    try:
        text = expand_xacro(file, "any", {"side": "left"}, PackageFolders({}, [], file)).text
        parse_urdf(text, file)
    except UrdfError as error:
        assert "any.xacro" in str(error)


def _xacro_expression(data: bytes) -> None:
    from cbdsl_formats.budget import StepBudget
    from cbdsl_formats.functions import ModelFunction, Namespace, functions
    from cbdsl_formats.xacro_expression import evaluate

    try:
        value = evaluate(data.decode("utf-8", "ignore"), functions({}), StepBudget())
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError, RecursionError):
        return
    allowed = (
        type(None),
        bool,
        int,
        float,
        complex,
        str,
        list,
        tuple,
        dict,
        ModelFunction,
        Namespace,
    )
    assert type(value) in allowed


def _mjcf(data: bytes) -> None:
    from cbdsl_formats.mjcf.conversion import convert_mjcf

    file = scratch() / "any.xml"
    file.write_bytes(data)
    try:
        converted = convert_mjcf(file, "any")
    except UrdfError as error:
        assert "any.xml" in str(error)
        return
    parse_urdf(converted.text, file)


def _mesh(data: bytes) -> None:
    """Search for the damage of a mesh; the first byte chooses its format."""
    file = scratch() / f"any{MESHES[data[0] % len(MESHES)] if data else '.stl'}"
    file.write_bytes(data[1:])
    _damage.cache_clear()
    damage = mesh_damage(file)
    damage.encode()
    assert "\n" not in damage and len(damage) < 300


def _meshes() -> Iterator[bytes]:
    for name, data in SOUND.items():
        yield bytes([MESHES.index(Path(name).suffix)]) + data
    for (name, _), data in DAMAGED.items():
        yield bytes([MESHES.index(Path(name).suffix)]) + data


def _urdfs() -> Iterator[bytes]:
    folders = (ROOT / "robots", ROOT / "tests" / "checking" / "bad")
    for folder in folders:
        for file in sorted(folder.rglob("*.urdf")):
            data = file.read_bytes()
            if len(data) <= _LARGEST:
                yield data
    yield _ARM


_ARM = b"""<robot name="arm">
  <material name="grey"><color rgba="0.5 0.5 0.5 1"/></material>
  <link name="base"><inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
  <link name="tip"><visual><origin xyz="0 0 1" rpy="0 0 0"/><geometry><box size="1 1 1"/></geometry>
    <material name="grey"/></visual>
    <collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="turn" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="10" velocity="2"/>
    <mimic joint="turn" multiplier="2"/></joint>
</robot>"""
_SRDF = b"""<robot name="arm">
  <group name="arm"><chain base_link="base" tip_link="tip"/><joint name="turn"/>
    <group name="hand"/></group>
  <group name="hand"><link name="tip"/></group>
  <group_state name="home" group="arm"><joint name="turn" value="0.5 1"/></group_state>
  <end_effector name="hand" group="hand" parent_link="base" parent_group="arm"/>
  <passive_joint name="turn"/><virtual_joint name="fix" type="fixed"/>
  <disable_collisions link1="base" link2="tip" reason="Never"/>
</robot>"""
_XACRO = b"""<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="arm">
  <xacro:arg name="side" default="left"/><xacro:property name="r" value="${2*0.1}"/>
  <xacro:macro name="rod" params="name length:=1 *origin"><link name="$(arg side)_${name}"/>
    <xacro:insert_block name="origin"/></xacro:macro>
  <xacro:rod name="base" length="${r}"><origin xyz="0 0 ${r/2}"/></xacro:rod>
  <xacro:if value="${r > 0.1}"><link name="more"/></xacro:if>
</robot>"""
_EXPRESSIONS = (
    b"-0.4 * pi / 2 if not 'left' in 'left' + '_arm' else round(1.25, 1)",
    b"list(map(float, '1 2 3'.split()))[0:2]",
    b"dict(a=1).get('a') + {'b': [1, 2]}['b'][-1] ** 2 // 3 % 4",
    b"python.sorted([sin(0.5), math.sqrt(2)]) <= xacro.tokenize('a,b', ',')",
)
_MJCF = b"""<mujoco model="arm"><compiler angle="radian"/><option gravity="0 0 -9.81"/>
  <worldbody><body name="base"><geom type="box" size="0.1 0.1 0.1"/>
    <body name="tip" pos="0 0 1"><joint name="turn" type="hinge" axis="0 0 1" range="-1 1"/>
    <geom type="capsule" size="0.05 0.2"/><site name="end"/></body></body></worldbody>
  <actuator><motor joint="turn" ctrlrange="-1 1" gear="5"/></actuator>
  <equality><joint joint1="turn" polycoef="0 1 0 0 0"/></equality></mujoco>"""

ENTRY_POINTS = {
    "urdf": EntryPoint(_urdf, _urdfs),
    "srdf": EntryPoint(_srdf, lambda: iter([_SRDF])),
    "xacro": EntryPoint(_xacro, lambda: iter([_XACRO, _ARM])),
    "xacro_expression": EntryPoint(_xacro_expression, lambda: iter(_EXPRESSIONS)),
    "mjcf": EntryPoint(_mjcf, lambda: iter([_MJCF])),
    "mesh": EntryPoint(_mesh, _meshes),
}
