"""Where fingertips touch, and with what force."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pybullet as p
from numpy.typing import NDArray

from cbdsl.backends.bullet.body import Body
from cbdsl.documents.robot import RobotDocument

Floats = NDArray[np.float64]
Cell = tuple[str, str]
Triple = tuple[float, float, float]


@dataclass(frozen=True)
class Touch:
    """One contact point of a fingertip.

    Attributes:
        cell: the fingertip's load cell, as (hand, finger).
        body: the simulator's number of what is touched.
        point: on the fingertip, in the world frame, m.
        force: that the fingertip exerts there, in the world frame, N.
        pressure: the force's share along the contact normal, N.
    """

    cell: Cell
    body: int
    point: Triple
    force: Triple
    pressure: float


class Fingertips:
    """The links that carry load cells.

    Attributes:
        cells: the load cells, as (hand, finger), in the robot file's order.
    """

    def __init__(self, client: int, robot: RobotDocument, body: Body) -> None:
        self._client = client
        self._body = body.id
        links = {
            (hand, finger): body.link(cell.link)
            for hand, fingers in robot.load_cells.items()
            for finger, cell in fingers.items()
        }
        self.cells: tuple[Cell, ...] = tuple(links)
        self._links = list(links.values())
        self._cell_of_link = {link: cell for cell, link in links.items()}

    def touches(self) -> list[Touch]:
        """The contact points of all fingertips, as of the last physics step."""
        found = []
        for contact in p.getContactPoints(bodyA=self._body, physicsClientId=self._client):
            body_a, body_b, link_a, link_b = contact[1:5]
            if not contact[9]:
                continue
            if body_a == self._body and link_a in self._cell_of_link:
                found.append(self._touch(contact, link_a, body_b, contact[5], -1.0))
            if body_b == self._body and link_b in self._cell_of_link:
                found.append(self._touch(contact, link_b, body_a, contact[6], 1.0))
        return found

    def _touch(self, contact: Any, link: int, other: int, point: Triple, sign: float) -> Touch:
        """``sign`` is 1 where the fingertip is contact's second body: forces act on the first."""
        (nx, ny, nz), pressure = contact[7], contact[9]
        f, (fx, fy, fz) = contact[10], contact[11]
        g, (gx, gy, gz) = contact[12], contact[13]
        force = (
            sign * (pressure * nx + f * fx + g * gx),
            sign * (pressure * ny + f * fy + g * gy),
            sign * (pressure * nz + f * fz + g * gz),
        )
        return Touch(self._cell_of_link[link], other, point, force, pressure)

    def wrenches(self) -> Floats:
        """What each fingertip exerts on the world, shape (cells, 6), world frame.

        Force, N, then torque about the fingertip's origin, N m.
        """
        touches = self.touches()
        sums = np.zeros((len(self.cells), 6))
        if not touches:
            return sums
        states = p.getLinkStates(self._body, self._links, physicsClientId=self._client)
        origins = {cell: state[4] for cell, state in zip(self.cells, states, strict=True)}
        for touch in touches:
            ox, oy, oz = origins[touch.cell]
            x, y, z = touch.point[0] - ox, touch.point[1] - oy, touch.point[2] - oz
            fx, fy, fz = touch.force
            torque = (y * fz - z * fy, z * fx - x * fz, x * fy - y * fx)
            sums[self.cells.index(touch.cell)] += (*touch.force, *torque)
        return sums
