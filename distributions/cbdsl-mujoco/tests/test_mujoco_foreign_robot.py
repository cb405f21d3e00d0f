"""Robots that are not Dexter: of meshes, with unfortunate names, and with links that overlap."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cbdsl.backends.backend import BackendError
from cbdsl.backends.staging.scenario import SceneObject
from cbdsl.backends.staging.shape import SolidShape
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument, Surface
from cbdsl.kinematics.pose import Pose
from cbdsl_mujoco.backend import MujocoBackend

STAGE = StageDocument.model_validate(
    {"cbdsl": 1, "kind": "stage", "name": "empty", "robot": "own", "contexts": {"empty": {}}}
)
# A pyramid of 20 cm with its top at 10 cm, and a square without height.
PYRAMID = "v 0.1 0.1 0\nv -0.1 0.1 0\nv -0.1 -0.1 0\nv 0.1 -0.1 0\nv 0 0 0.1\n"
PYRAMID += "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\nf 3 2 1\nf 4 3 1\n"
SQUARE = "v 0.1 0.1 0\nv -0.1 0.1 0\nv -0.1 -0.1 0\nv 0.1 -0.1 0\nf 1 2 3\nf 1 3 4\n"


def model(base: str, geometry: str, upper: str = '<sphere radius="0.05"/>') -> str:
    """Return the URDF of a column on a base, which turns about the vertical 40 cm above it."""
    return f"""<robot name="own"><link name="{base}">
      <collision><geometry>{geometry}</geometry></collision></link>
    <joint name="turn" type="revolute"><parent link="{base}"/><child link="upper"/>
      <origin xyz="0 0 0.4"/><axis xyz="0 0 1"/>
      <limit lower="-2" upper="2" effort="10" velocity="2"/></joint>
    <link name="upper"><inertial><mass value="1"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
      <collision><geometry>{upper}</geometry></collision></link>
    <joint name="nod" type="revolute"><parent link="upper"/><child link="last"/>
      <origin xyz="0.3 0 0"/><axis xyz="0 1 0"/>
      <limit lower="-2" upper="2" effort="10" velocity="2"/></joint>
    <link name="last"><inertial><mass value="1"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
      <collision><geometry><box size="0.02 0.02 0.9"/></geometry></collision></link>
    </robot>"""


def make(folder: Path, text: str, base: str = "base", **more: Any) -> MujocoBackend:
    urdf = folder / "own.urdf"
    urdf.write_text(text, encoding="utf-8")
    arm = {"joints": ["turn", "nod"], "postures": {"home": [0.0, 0.0]}, "start": "home"}
    robot = RobotDocument.model_validate(
        {
            **{"cbdsl": 1, "kind": "robot", "name": "own", "model": "own.urdf", "base": base},
            **{"effectors": {"arm": arm}, "control": {"rate": 60, "tasks": {}}, **more},
        }
    )
    backend = MujocoBackend(robot, urdf)
    backend.reset(STAGE, None, np.random.default_rng(0))
    return backend


def mesh(folder: Path, content: str, scale: str = "1 1 1") -> str:
    (folder / "part.obj").write_text(content, encoding="utf-8")
    return f'<mesh filename="part.obj" scale="{scale}"/>'


def test_mesh_collides_as_its_hull(tmp_path: Path) -> None:
    backend = make(tmp_path, model("base", mesh(tmp_path, PYRAMID, "1 1 2")))
    ball = Pose(np.array([0.0, 0.0, 0.3]), np.eye(3))
    engine = backend.truth
    engine.add(SceneObject("ball", SolidShape.ball(0.04), Surface(), 0.2, ball))
    for _ in range(12):
        backend.step()
    # The scaled pyramid ends at 20 cm, and the ball comes to it after 0.11 s.
    assert engine.pose("ball").position[2] > 0.2
    assert engine.touched("ball")
    backend.close()


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (SQUARE, "part.obj, which is flat"),
        ("nothing", "is damaged: it has no triangles"),
        (None, "does not exist"),
    ],
)
def test_mesh_that_cannot_collide_is_refused(tmp_path: Path, content: str | None, why: str) -> None:
    given = mesh(tmp_path, content or "")
    if content is None:
        (tmp_path / "part.obj").unlink()
    with pytest.raises(BackendError, match=f"own.urdf: .*link 'base' .*{why}"):
        make(tmp_path, model("base", given))


def test_shape_without_extent_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BackendError, match="link 'base' has a ball without extent"):
        make(tmp_path, model("base", '<sphere radius="0"/>'))


def test_link_may_have_the_name_of_the_world(tmp_path: Path) -> None:
    backend = make(tmp_path, model("world", '<box size="0.1 0.1 0.1"/>'), "world")
    assert set(backend.truth.rows) == {"world", "upper", "last"}
    assert backend.truth.link_pose("last").position == pytest.approx([0.3, 0, 0.4], abs=1e-9)
    backend.close()


def test_links_that_overlap_at_the_start_do_not_move(tmp_path: Path) -> None:
    """Two links hang side by side on the base, one inside the other."""
    twin = (
        '<joint name="twin" type="fixed"><parent link="base"/><child link="twin"/>'
        '<origin xyz="0.3 0 0.4"/></joint><link name="twin"><collision><geometry>'
        '<sphere radius="0.06"/></geometry></collision></link></robot>'
    )
    text = model("base", '<box size="0.1 0.1 0.1"/>').replace("</robot>", twin)
    backend = make(tmp_path, text)
    for _ in range(60):
        backend.step()
    assert backend.observe().positions == pytest.approx([0.0, 0.0], abs=1e-3)
    backend.close()


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_joint_without_effort_and_velocity_limits_holds_its_reference(tmp_path: Path) -> None:
    unbounded = model("base", '<box size="0.1 0.1 0.1"/>').replace(
        'effort="10" velocity="2"', 'effort="0" velocity="0"'
    )
    backend = make(tmp_path, unbounded)
    for _ in range(30):
        backend.step()
    assert backend.observe().positions == pytest.approx([0.0, 0.0], abs=1e-2)
    backend.close()
