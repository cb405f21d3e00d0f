"""Surfaces of links: objects that rest on a soft link under load."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pybullet as p
import pytest

from cbdsl.backends.bullet.articulation import BulletRobot
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.urdf_reader import read_urdf

SLOPE = math.radians(15)
PLATE = f"""<robot name="plate">
  <link name="base"/>
  <link name="plate">
    <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="1 1 0.1"/></geometry></collision>
  </link>
  <joint name="slope" type="fixed">
    <parent link="base"/><child link="plate"/><origin rpy="0 {SLOPE} 0"/>
  </joint>
</robot>"""


@pytest.fixture
def client() -> Iterator[int]:
    client = p.connect(p.DIRECT)
    p.setGravity(0, 0, -9.81, physicsClientId=client)
    p.setTimeStep(1 / 240, physicsClientId=client)
    yield client
    p.disconnect(physicsClientId=client)


def slide(client: int, folder: Path, **surface: Any) -> float:
    """Return the creep of a box on a plate too rough for it to slide, m in 3 s."""
    file = folder / "plate.urdf"
    file.write_text(PLATE)
    robot = RobotDocument.model_validate(
        {
            "cbdsl": 1,
            "kind": "robot",
            "name": "plate",
            "model": file.name,
            "base": "base",
            "effectors": {},
            "control": {"rate": 60, "tasks": {}},
            "simulation": {"surfaces": [{"links": ["plate"], "friction": 1, **surface}]},
        }
    )
    BulletRobot(client, robot, read_urdf(file), 1 / 240)
    shape = p.createCollisionShape(p.GEOM_BOX, halfExtents=[0.05] * 3, physicsClientId=client)
    normal = np.array([math.sin(SLOPE), 0, math.cos(SLOPE)])
    turn = p.getQuaternionFromEuler([0, SLOPE, 0])
    box = p.createMultiBody(0.25, shape, -1, (0.1 * normal).tolist(), turn, physicsClientId=client)
    p.changeDynamics(box, -1, lateralFriction=0.8, physicsClientId=client)
    places = []
    for count in (240, 720):
        for _ in range(count):
            p.stepSimulation(physicsClientId=client)
        places.append(np.array(p.getBasePositionAndOrientation(box, physicsClientId=client)[0]))
    return float(np.linalg.norm(places[1] - places[0]))


def test_friction_anchor_stops_creep_on_a_soft_surface(client: int, tmp_path: Path) -> None:
    soft = {"stiffness": 3000, "damping": 60}
    assert slide(client, tmp_path, **soft) > 5e-5
    p.resetSimulation(physicsClientId=client)
    p.setGravity(0, 0, -9.81, physicsClientId=client)
    assert slide(client, tmp_path, **soft, friction_anchor=True) < 1e-9
