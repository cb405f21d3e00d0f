"""Links: at the poses of the robot's kinematics, for every robot file; meshes are found."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pybullet_data
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.kinematics.quaternion import rotations
from cbdsl.reporting.drawn_links import DrawnLink, LinkShape, read_links
from cbdsl.robot.urdf_reader import parse_urdf
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

LIBRARY = Library(ROOT)
ROBOTS = [
    LIBRARY.read(LIBRARY.locate(RobotDocument, name), RobotDocument).document
    for name in LIBRARY.names(RobotDocument)
]


def told(robot: RobotDocument, urdf: Path) -> dict[str, object]:
    """Return a robot as recordings store it."""
    couplings = {name: [each.follows, each.ratio] for name, each in robot.couplings.items()}
    text = urdf.read_text("utf-8")
    return {"urdf": text, "folder": str(urdf.parent), "couplings": couplings}


def placed(links: list[DrawnLink], angles: np.ndarray) -> dict[str, np.ndarray]:
    """Return the links' world frames, shape (4, 4) each, as the page's script moves them."""
    frames: list[np.ndarray] = []
    for link in links:
        frame = np.eye(4) if link.parent < 0 else frames[link.parent]
        frame = frame @ transform(link.position, link.quaternion)
        if link.motion == "turn":
            driven = link.ratio * angles[link.column] if link.column >= 0 else 0.0
            half = (driven + link.offset) / 2
            axis = np.array(link.axis) / np.linalg.norm(link.axis)
            frame = frame @ transform((0, 0, 0), (*(np.sin(half) * axis), np.cos(half)))
        elif link.motion == "slide":
            driven = link.ratio * angles[link.column] if link.column >= 0 else 0.0
            axis = np.array(link.axis) / np.linalg.norm(link.axis)
            frame = frame @ transform(tuple((driven + link.offset) * axis), (0, 0, 0, 1))
        frames.append(frame)
    return dict(zip((link.name for link in links), frames, strict=True))


def transform(position: tuple[float, ...], quaternion: tuple[float, ...]) -> np.ndarray:
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = rotations(np.array(quaternion)), position
    return result


@pytest.mark.parametrize("robot", ROBOTS, ids=[robot.name for robot in ROBOTS])
def test_drawn_links_agree_with_the_kinematics(robot: RobotDocument) -> None:
    urdf = ROOT / "robots" / robot.model
    kinematics = Kinematics(robot, urdf)
    links = read_links(told(robot, urdf), kinematics.joints.names)
    rng = np.random.default_rng(1)
    for _ in range(5):
        angles = rng.uniform(kinematics.lower, kinematics.upper)
        kinematics.update(angles)
        for name, frame in placed(links, angles).items():
            expected = kinematics.frame(name)
            assert frame[:3, 3] == pytest.approx(expected.position, abs=1e-9)
            assert frame[:3, :3] == pytest.approx(expected.rotation, abs=1e-9)


@pytest.mark.parametrize("robot", ROBOTS, ids=[robot.name for robot in ROBOTS])
def test_visible_links_have_a_shape_and_a_colour(robot: RobotDocument) -> None:
    urdf = ROOT / "robots" / robot.model
    links = read_links(told(robot, urdf), Kinematics(robot, urdf).joints.names)
    shapes = [shape for link in links for shape in link.shapes]
    assert len(shapes) == urdf.read_text("utf-8").count("<visual>")
    sizes = {"ball": 1, "box": 3, "cylinder": 2}
    assert all(len(shape.size) == sizes[shape.shape] for shape in shapes)
    assert all(0 <= part <= 1 for shape in shapes for part in shape.color)
    colors = set(re.findall(r'<color rgba="[^"]*"', urdf.read_text("utf-8")))
    assert len({shape.color for shape in shapes}) == len(colors)


def test_meshes_are_found_beside_the_model_and_omitted_if_missing(
    tmp_path: Path,
) -> None:
    urdf = Path(pybullet_data.getDataPath()) / "kuka_iiwa" / "model.urdf"
    robot = {"urdf": urdf.read_text("utf-8"), "folder": str(urdf.parent), "couplings": {}}
    shapes = [shape for link in read_links(robot, ()) for shape in link.shapes]
    assert len(shapes) == 8 and {shape.shape for shape in shapes} == {"mesh"}
    gone = read_links({**robot, "folder": str(tmp_path)}, ())
    assert len(gone) == 8
    assert {shape.shape for link in gone for shape in link.shapes} == {"ball", "cylinder"}


@pytest.mark.parametrize("robot", ROBOTS, ids=[robot.name for robot in ROBOTS])
def test_model_that_shows_nothing_is_a_skeleton_from_joint_to_joint(robot: RobotDocument) -> None:
    urdf = ROOT / "robots" / robot.model
    described = told(robot, urdf)
    bare = re.sub(r"<visual>.*?</visual>", "", described["urdf"], flags=re.DOTALL)
    joints = parse_urdf(bare, urdf).joints.values()
    links = read_links({**described, "urdf": bare}, Kinematics(robot, urdf).joints.names)
    shapes = {link.name: link.shapes for link in links}
    for joint in joints:
        own = shapes[joint.parent]
        assert any(s.shape == "ball" and s.position == joint.origin.xyz for s in own)
        if joint.length and joint.kind != "prismatic":  # whose rod is as long as its travel
            ends = [end for s in own if s.shape == "cylinder" for end in ends_of(s)]
            assert any(np.allclose(end, joint.origin.xyz) for end in ends)
            assert any(np.allclose(end, 0.0) for end in ends)


def ends_of(rod: LinkShape) -> list[np.ndarray]:
    """Return both ends of a cylinder's axis, m."""
    x, y, z, w = rod.quaternion
    axis = np.array([2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)])
    return [np.array(rod.position) + sign * rod.size[1] / 2 * axis for sign in (-1, 1)]


def test_read_links_of_a_coupled_joint_has_ratio_and_offset() -> None:
    text = """<robot name="pair"><link name="a"/><link name="b"/><link name="c"/>
    <joint name="ab" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
      <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
    <joint name="bc" type="prismatic"><parent link="b"/><child link="c"/><axis xyz="1 0 0"/>
      <limit effort="1" velocity="1"/>
      <mimic joint="ab" multiplier="-2" offset="0.5"/></joint></robot>"""
    coupled = {"urdf": text, "folder": ".", "couplings": {"bc": ["ab", -2, 0.5]}}
    last = read_links(coupled, ["ab"])[-1]
    assert (last.name, last.motion, last.column) == ("c", "slide", 0)
    assert (last.ratio, last.offset) == (-2.0, 0.5)
    before = {**coupled, "couplings": {"bc": ["ab", -2]}}
    assert read_links(before, ["ab"])[-1].offset == 0.0


def test_read_links_of_an_undriven_joint_shows_it_at_rest() -> None:
    text = """<robot name="pair"><link name="a"/><link name="b"/>
    <joint name="ab" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
      <limit lower="0.5" upper="1" effort="1" velocity="1"/></joint></robot>"""
    last = read_links({"urdf": text, "folder": ".", "couplings": {}}, [])[-1]
    assert (last.column, last.offset) == (-1, 0.5)


def test_read_links_of_a_recording_shows_no_mesh_from_elsewhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ball = (ROOT / "robots").rglob("*.stl")
    data = next(iter(ball), None)
    secret = tmp_path / "private" / "part.stl"
    secret.parent.mkdir()
    text = "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
    secret.write_bytes(data.read_bytes() if data else f"{text}endloop\nendfacet\nendsolid".encode())
    here = tmp_path / "here"
    here.mkdir()
    for name in (str(secret), "../private/part.stl", f"file://{secret}"):
        link = (
            f"<link name='a'><visual><geometry><mesh filename='{name}'/></geometry></visual></link>"
        )
        robot = {"urdf": f"<robot name='r'>{link}</robot>", "folder": str(here), "couplings": {}}
        monkeypatch.chdir(here)
        (recorded,), (own,) = read_links(robot, []), read_links(robot, [], is_recorded=False)
        assert not recorded.shapes and own.shapes
        monkeypatch.chdir(tmp_path)
        assert read_links(robot, [])[0].shapes
