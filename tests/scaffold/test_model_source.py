"""``cb new robot`` from xacro, SRDF and MJCF: valid output, and messages that name mistakes."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.diagnostics.diagnostic import Severity
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.yaml_text.library import Library
from tests.cli.test_main import cb

HEAD = '<robot name="desk" xmlns:xacro="http://www.ros.org/wiki/xacro">'
MACRO = f"""{HEAD}
  <xacro:macro name="hinge" params="name parent lower:=-2">
    <link name="${{name}}_link"><inertial><mass value="${{mass}}"/>
      <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="${{name}}" type="revolute">
      <parent link="${{parent}}"/><child link="${{name}}_link"/><origin xyz="0 0 0.2"/>
      <axis xyz="0 1 0"/><limit lower="${{lower}}" upper="2" effort="30" velocity="2"/>
    </joint>
  </xacro:macro>
</robot>"""
MODEL = f"""{HEAD}
  <xacro:arg name="mass" default="1.0"/>
  <xacro:property name="mass" value="$(arg mass)"/>
  <xacro:include filename="$(find desk_description)/joint.xacro"/>
  <link name="base"/>
  <xacro:hinge name="shoulder" parent="base"/>
  <xacro:hinge name="elbow" parent="shoulder_link" lower="0"/>
  <link name="tool"><visual><geometry>
    <mesh filename="package://desk_description/tool.stl"/></geometry></visual></link>
  <joint name="flange" type="fixed"><parent link="elbow_link"/><child link="tool"/></joint>
  <link name="jaw"/>
  <joint name="grip" type="prismatic"><parent link="tool"/><child link="jaw"/>
    <axis xyz="0 1 0"/><limit lower="0" upper="0.04" effort="20" velocity="0.2"/></joint>
  <link name="lid"/>
  <joint name="hatch" type="revolute"><parent link="base"/><child link="lid"/>
    <limit lower="0" upper="1" effort="20" velocity="0.2"/></joint>
</robot>"""
SRDF = """<robot name="desk">
  <virtual_joint name="roam" type="planar" parent_frame="world" child_link="base"/>
  <group name="arm"><chain base_link="base" tip_link="tool"/></group>
  <group name="hand"><link name="jaw"/></group>
  <group name="arm_hand"><group name="arm"/><group name="hand"/></group>
  <group name="lower"><joint name="shoulder"/></group>
  <group_state name="up-right" group="arm">
    <joint name="shoulder" value="0.5"/><joint name="elbow" value="1.25"/></group_state>
  <group_state name="far" group="arm">
    <joint name="shoulder" value="9"/><joint name="elbow" value="1"/></group_state>
  <group_state name="whole" group="arm_hand"><joint name="shoulder" value="0"/>
    <joint name="elbow" value="0"/><joint name="grip" value="0.03"/></group_state>
  <end_effector name="gripper" parent_link="elbow_link" group="hand" parent_group="arm"/>
  <disable_collisions link1="shoulder_link" link2="jaw" reason="Never"/>
  <disable_collisions link1="tool" link2="jaw" reason="Adjacent"/>
  <disable_collisions link1="shoulder_lnk" link2="jaw" reason="Never"/>
</robot>"""
TRIANGLE = (
    "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
    "endloop\nendfacet\nendsolid t\n"
)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Change to a working folder; the robot's package is in another folder."""
    package = tmp_path / "elsewhere" / "desk_description"
    package.mkdir(parents=True)
    (package / "joint.xacro").write_text(MACRO)
    (package / "tool.stl").write_text(TRIANGLE)
    work = tmp_path / "work"
    work.mkdir()
    (work / "desk.urdf.xacro").write_text(MODEL)
    (work / "desk.srdf").write_text(SRDF)
    monkeypatch.chdir(work)
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    return work


MADE = ("new", "robot", "arm", "--urdf", "desk.urdf.xacro")
PACKAGE = ("--package", "desk_description=../elsewhere/desk_description")


def robot(folder: Path) -> RobotDocument:
    path = folder / "robots" / "arm.yaml"
    assert not [each for each in check_document(path) if each.severity is not Severity.NOTE]
    return Library(folder).read(path, RobotDocument).document


def test_xacro_is_expanded_beside_the_robot(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert cb(monkeypatch, *MADE, *PACKAGE, "--xacro-arg", "mass:=2.5") == 0
    assert robot(folder).model == "arm.urdf"
    urdf = folder / "robots" / "arm.urdf"
    assert "From ../desk.urdf.xacro, expanded by xacro mass:=2.5" in urdf.read_text()
    model = read_urdf(urdf)
    inertial = model.bodies["elbow_link"].inertial
    assert inertial is not None and inertial.mass == 2.5
    assert model.joints["elbow"].lower == 0 and model.joints["shoulder"].lower == -2
    (mesh,) = model.meshes
    assert (urdf.parent / mesh).read_text() == TRIANGLE


def test_packages_are_where_the_path_of_ros_says(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"/nowhere:{folder.parent / 'elsewhere'}")
    assert cb(monkeypatch, *MADE) == 0


def test_groups_become_effectors_and_states_postures(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, *MADE, *PACKAGE, "--srdf", "desk.srdf") == 0
    body, told = robot(folder), capsys.readouterr().err
    arm, hand = body.effectors["arm"], body.effectors["hand"]
    assert set(body.effectors) == {"arm", "hand"}
    assert arm.joints == ("shoulder", "elbow") and hand.joints == ("grip",)
    assert arm.postures == {"up_right": (0.5, 1.25), "whole": (0, 0)} and arm.start == "up_right"
    assert hand.postures == {"whole": (0.03,)}
    assert arm.tip is not None and arm.tip.link == "elbow_link"
    assert body.groups["arm_hand"].members == ("arm", "hand")
    assert body.simulation.no_contact == (("shoulder_link", "jaw"),)
    for words in (
        "group 'lower' has joints of 'arm'",
        "posture 'far' of 'arm' is left out: 9 of joint 'shoulder'",
        "did you mean 'shoulder_link'?",
        "virtual joint 'roam' is planar",
        "1 in no group of the SRDF",
    ):
        assert words in told
    assert "# - hatch: in no group" in (folder / "robots" / "arm.yaml").read_text()


def test_mjcf_becomes_a_robot_with_its_meshes(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "parts.xml").write_text(
        '<mujoco><asset><mesh name="m" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset></mujoco>'
    )
    (folder / "arm.xml").write_text(
        '<mujoco><include file="parts.xml"/><worldbody><body name="a">'
        '<joint name="turn" range="-90 90"/><geom type="mesh" mesh="m"/>'
        "</body></worldbody></mujoco>"
    )
    assert cb(monkeypatch, "new", "robot", "arm", "--urdf", "arm.xml") == 0
    assert robot(folder).base == "world"
    assert (folder / "robots" / "arm_meshes" / "m.stl").is_file()
    assert "'turn' is a joint without an actuator" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (MADE, "package 'desk_description' is nowhere; --package desk_description=FOLDER"),
        ((*MADE, "--package", "desk_descripton=."), "did you mean 'desk_descripton'?"),
        ((*MADE, *PACKAGE, "--xacro-arg", "mas:=2"), "did you mean 'mass'?"),
        ((*MADE, *PACKAGE, "--xacro-arg", "mass=2"), "is not of the form NAME:=VALUE"),
        ((*MADE, *PACKAGE, "--xacro-arg", "mass:=heavy"), 'has value="heavy"'),
        ((*MADE, *PACKAGE, "--srdf", "bad.srdf"), "did you mean 'shoulder'?"),
        ((*MADE, *PACKAGE, "--srdf", "circle.srdf"), "group 'a' is in itself"),
        ((*MADE, *PACKAGE, "--srdf", "none.srdf"), "cb: srdf none.srdf: No such file"),
        (("new", "robot", "arm", "--urdf", "none.urdf", *PACKAGE), "No such file"),
        (("new", "robot", "arm", "--urdf", "bad.xacro"), "xacro cannot expand it"),
    ],
)
def test_mistakes_are_named_and_nothing_is_written(
    arguments: tuple[str, ...],
    words: str,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (folder / "bad.srdf").write_text(SRDF.replace('"shoulder"/>', '"sholder"/>'))
    (folder / "circle.srdf").write_text(
        '<robot name="d"><group name="a"><group name="b"/></group>'
        '<group name="b"><group name="a"/></group></robot>'
    )
    (folder / "bad.xacro").write_text(f"{HEAD}<xacro:hinge/></robot>")
    assert cb(monkeypatch, *arguments) == 2
    told = capsys.readouterr().err
    assert words in told and "Traceback" not in told
    assert not (folder / "robots").exists()


@pytest.mark.parametrize(
    "body",
    [
        '<replicate count="1000000000"><body><geom size="1"/></body></replicate>',
        '<replicate count="5000"><replicate count="5000"><geom size="1"/></replicate></replicate>',
    ],
)
def test_new_robot_from_mjcf_with_many_copies_is_refused(
    body: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "arm.xml").write_text(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
    assert cb(monkeypatch, "new", "robot", "arm", "--urdf", "arm.xml") == 2
    assert "copies of a part; at most 10000" in capsys.readouterr().err


@pytest.mark.slow
def test_new_robot_from_mjcf_that_takes_long_ends(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    body = '<replicate count="1000000" offset="0 0 1"><body><geom size="1"/></body></replicate>'
    (folder / "parts.xml").write_text(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
    (folder / "arm.xml").write_text('<mujoco><include file="parts.xml"/></mujoco>')
    assert cb(monkeypatch, "new", "robot", "arm", "--urdf", "arm.xml") == 2
    assert "MuJoCo cannot compile it within 10 s" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize(
    "model",
    [
        '<mujoco><include file="pipe"/></mujoco>',
        '<mujoco><asset><mesh name="m" file="pipe.stl"/></asset></mujoco>',
        '<mujoco><asset><hfield name="h" size="1 1 1 1" file="pipe.png"/></asset></mujoco>',
    ],
)
def test_new_robot_from_mjcf_that_names_a_pipe_ends(
    model: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("pipe", "pipe.stl", "pipe.png"):
        os.mkfifo(folder / name)
    (folder / "arm.xml").write_text(model)
    assert cb(monkeypatch, "new", "robot", "arm", "--urdf", "arm.xml") == 2
    assert "MuJoCo waits for a file that it names" in capsys.readouterr().err


@pytest.mark.parametrize("suffix", [".urdf", ".srdf", ".xml", ""])
def test_new_robot_from_xacro_by_another_name_needs_the_option(
    suffix: str,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (folder / f"desk{suffix}").write_text(MODEL)
    made = ("new", "robot", "arm", "--urdf", f"desk{suffix}", *PACKAGE)
    assert cb(monkeypatch, *made) == 2
    assert "it is xacro, and its name does not end in .xacro" in capsys.readouterr().err
    assert cb(monkeypatch, *made, "--xacro") == 0


def test_new_robot_from_groups_in_xacro_by_another_name_expands_nothing(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "bad.srdf").write_text(f'{HEAD}<xacro:include filename="none"/></robot>')
    made = (*MADE, *PACKAGE, "--srdf", "bad.srdf")
    assert cb(monkeypatch, *made) == 2
    assert "srdf bad.srdf: it is xacro" in capsys.readouterr().err
    assert cb(monkeypatch, *made, "--force", "--xacro") == 2
    assert "xacro cannot expand it" in capsys.readouterr().err


@pytest.mark.parametrize("library", ["xacro", "mujoco"])
def test_without_the_extra_its_name_is_reported(
    library: str,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    for module in ("cbdsl_formats.expansion", "cbdsl_formats.mjcf.bounded_conversion"):
        monkeypatch.delitem(sys.modules, module, raising=False)
    monkeypatch.setitem(sys.modules, library, None)
    (folder / "arm.xml").write_text("<mujoco/>")
    file = "arm.xml" if library == "mujoco" else "desk.urdf.xacro"
    assert cb(monkeypatch, "new", "robot", "arm", "--urdf", file) == 2
    told = capsys.readouterr().err
    assert library in told and "pip install 'cbdsl[formats]'" in told


def test_model_is_never_written_over(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "robots").mkdir()
    source = folder / "robots" / "arm.urdf"
    source.write_text(MODEL)
    made = ("new", "robot", "arm", "--urdf", "robots/arm.urdf", "--xacro", "--force", *PACKAGE)
    assert cb(monkeypatch, *made) == 2
    assert source.read_text() == MODEL


@pytest.mark.parametrize("folder", ["/nope", "", "model.urdf"])
def test_package_without_a_folder_is_refused_for_any_model(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    folder: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "model.urdf").write_text('<robot name="a"><link name="base"/></robot>', "utf-8")
    words = ("new", "robot", "a", "--urdf", "model.urdf", "--package", f"other={folder}")
    assert cb(monkeypatch, *words) == 2
    assert f"--package other={folder}: there is no folder '{folder}'" in capsys.readouterr().err
    assert not (tmp_path / "robots").exists()


def test_package_in_two_folders_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "model.urdf").write_text('<robot name="a"><link name="base"/></robot>', "utf-8")
    packages = ("--package", "other=.", "--package", "other=/")
    assert cb(monkeypatch, "new", "robot", "a", "--urdf", "model.urdf", *packages) == 2
    assert "--package gives 'other' twice: . and /" in capsys.readouterr().err


@pytest.mark.parametrize("sign", ["&#10;", "&#13;", "&#x85;", "&#x2028;", "&#9;"])
def test_new_robot_from_names_with_line_breaks_writes_no_keys_of_them(
    sign: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = f"j{sign}base: evil{sign}owned: 1"
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    links = "".join(f'<link name="{link}"/>' for link in ("a", "b", "c", "d"))
    joints = "".join(
        f'<joint name="{name}{k}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f"{limit}</joint>"
        for k, (kind, parent, child) in enumerate(
            [("revolute", "a", "b"), ("revolute", "b", "c"), ("floating", "a", "d")]
        )
    )
    (folder / "odd.urdf").write_text(f'<robot name="odd">{links}{joints}</robot>', "utf-8")
    cb(monkeypatch, "new", "robot", "arm", "--urdf", "odd.urdf")
    written = folder / "robots" / "arm.yaml"
    if written.exists():
        import yaml

        data = yaml.safe_load(written.read_text("utf-8"))
        assert "owned" not in data and data["base"] == "a"
