"""Shapes of the robot whose surfaces are soft."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

from cbdsl.backends.mujoco.robot_spec import body_name
from cbdsl.backends.staging.links import link_surfaces
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.urdf import UrdfModel

# Bounds of the impedances with which the solver is stable.
_SOFTEST, _STIFFEST = 0.2, 0.99
# Width, middle and power of an impedance that does not change with depth.
_SHAPE = [0.001, 0.5, 2.0]


class SoftShape(NamedTuple):
    """Shape of the robot whose surface has a stiffness and a damping.

    Attributes:
        geom: Name of the shape in the specification.
        friction: Coefficient of lateral friction.
        stiffness: Stiffness, N/m.
        damping: Damping, N s/m.
        mobility: Mobility of the link, 1/kg: inverse of its inertia against a push.
    """

    geom: str
    friction: float
    stiffness: float
    damping: float
    mobility: float

    def press(self, spec: Any, geom: Any, mobility: float, movable: bool) -> Any:
        """Add the contact pair of this soft shape with a shape of an object; return the pair.

        MuJoCo pushes two bodies apart with the force impedance / (1 - impedance) / mobility times
        the acceleration of a critically damped spring (its documentation, "Solver parameters").
        So the stiffness is 1 / ((1 - impedance) mobility time^2), and the damping is twice the
        stiffness times the time constant.

        Args:
            spec: Specification of the world.
            geom: Shape of the object.
            mobility: Mobility of the object, 1/kg.
            movable: True if the object's friction counts.
        """
        # Two unknowns, impedance and time, follow from two equations, stiffness and damping. The
        # damping gives the time, and the stiffness then gives the impedance.
        together = max(self.mobility + mobility, 1e-9)
        time = max(self.damping / (2.0 * self.stiffness), 2.0 * spec.option.timestep)
        impedance = 1.0 - 1.0 / (self.stiffness * together * time**2)
        # The time is too short for the stiffness, for example with little damping. The stiffness is
        # kept, and the damping becomes larger than requested.
        if impedance < _SOFTEST:
            impedance = _SOFTEST
            time = math.sqrt(1.0 / ((1.0 - impedance) * self.stiffness * together))
        impedance = min(impedance, _STIFFEST)
        friction, spinning, rolling = geom.friction
        sliding = friction if movable else max(friction, self.friction)
        return spec.add_pair(
            geomname1=self.geom,
            geomname2=geom.name,
            condim=geom.condim,
            friction=[sliding, sliding, spinning, rolling, rolling],
            solref=[time, 1.0],
            solimp=[impedance, impedance, *_SHAPE],
        )


def soft_shapes(robot: RobotDocument, model: UrdfModel, compiled: Any) -> Iterator[SoftShape]:
    """Yield the shapes of links whose surfaces have a stiffness in the robot file.

    Args:
        robot: Robot document, which names surfaces.
        model: URDF model of the robot.
        compiled: MuJoCo's model of the robot.
    """
    for link, surface in link_surfaces(robot, model).items():
        if surface.stiffness is None:
            continue
        body = compiled.body(body_name(link))
        mobility = float(compiled.body_invweight0[body.id][0])
        first = int(body.geomadr[0])
        for number in range(first, first + int(body.geomnum[0])):
            yield SoftShape(
                compiled.geom(number).name,
                surface.friction,
                surface.stiffness,
                surface.damping or 0.0,
                mobility,
            )
