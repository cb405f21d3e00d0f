"""Contact sensors of the fingertips, summed to wrenches about the fingertips' origins."""

from __future__ import annotations

from typing import Any

import mujoco as mj
import numpy as np

from cbdsl.extend.backend import Cell, Floats, RobotDocument, Rows, compiled_once
from cbdsl_mujoco.robot_spec import body_name

_FIELDS = (
    mj.mjtConDataField.mjCONDATA_FORCE,
    mj.mjtConDataField.mjCONDATA_TORQUE,
    mj.mjtConDataField.mjCONDATA_POS,
)
# Reduction by which a sensor returns one sum of all contacts, in the world frame.
_NET_FORCE = 3


def add_sensors(spec: Any, robot: RobotDocument) -> None:
    """Add a contact sensor of each fingertip's wrench on the world."""
    fields = sum(1 << int(field) for field in _FIELDS)
    for (hand, finger), link in cell_links(robot).items():
        spec.add_sensor(
            name=f"{hand}/{finger}",
            type=mj.mjtSensor.mjSENS_CONTACT,
            objtype=mj.mjtObj.mjOBJ_BODY,
            objname=body_name(link),
            intprm=[fields, _NET_FORCE, 1],
        )


def cell_links(robot: RobotDocument) -> dict[Cell, str]:
    """Return the link that carries each load cell, in the robot file's order."""
    return {
        (hand, finger): cell.link
        for hand, fingers in robot.load_cells.items()
        for finger, cell in fingers.items()
    }


def sensor_addresses(model: Any, robot: RobotDocument) -> Rows:
    """Return the first index of each cell's reading in a compiled model, shape (cells,)."""
    names = (f"{hand}/{finger}" for hand, finger in cell_links(robot))
    return np.array([int(model.sensor(name).adr[0]) for name in names], dtype=np.intp)


@compiled_once
def sum_wrenches(
    readings: Floats, addresses: Rows, origins: Floats, fingertips: Rows, wrenches: Floats
) -> None:
    """Sum the sensors' readings to wrenches about the fingertips' origins.

    Args:
        readings: Readings of all sensors: force, N, torque, N m, and their point, m, 3 numbers
            each.
        addresses: First index of each cell's reading, shape (cells,).
        origins: Origins of all bodies, m, shape (bodies, 3).
        fingertips: Bodies of the cells, shape (cells,).
        wrenches: Output: wrenches, world frame, shape (cells, 6).
    """
    for cell in range(len(addresses)):
        own, wrench = readings[addresses[cell] :], wrenches[cell]
        origin = origins[fingertips[cell]]
        # The sensor's torque is about the point p that it reports. About the origin o it is torque
        # + (p - o) x force.
        x, y, z = own[6] - origin[0], own[7] - origin[1], own[8] - origin[2]
        for part in range(6):
            wrench[part] = own[part]
        if own[0] != 0.0 or own[1] != 0.0 or own[2] != 0.0:
            wrench[3] += y * own[2] - z * own[1]
            wrench[4] += z * own[0] - x * own[2]
            wrench[5] += x * own[1] - y * own[0]
