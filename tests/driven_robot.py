"""A robot of two joints with one driver."""

from __future__ import annotations

import numpy as np

from cbdsl.documents.robot import RobotDocument

URDF = """<robot name="rail">
<link name="base"/><link name="one"/><link name="two"/>
<joint name="first" type="revolute"><parent link="base"/><child link="one"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" velocity="2" effort="10"/></joint>
<joint name="second" type="revolute"><parent link="one"/><child link="two"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" velocity="1" effort="5"/></joint>
</robot>"""
NAMES = ("first", "second")
LOWER, UPPER = np.array([-1.0, -2.0]), np.array([1.0, 2.0])
VELOCITY = np.array([2.0, 1.0])
RATE = 50.0
PERIOD = 1.0 / RATE


def robot(**driver: object) -> RobotDocument:
    """Return the robot, with changes of its driver."""
    section = {"kind": "ros2", "moves": ["arm"], "states": "/joint_states", "commands": "/commands"}
    return RobotDocument.model_validate(
        {
            "cbdsl": 1,
            "kind": "robot",
            "name": "rail",
            "model": "rail.urdf",
            "base": "base",
            "effectors": {"arm": {"joints": list(NAMES)}},
            "drivers": {"arm": {**section, **driver}},
            "control": {"rate": RATE, "tasks": {}},
        }
    )
