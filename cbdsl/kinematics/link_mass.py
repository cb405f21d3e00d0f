"""Masses of links as all engines simulate them."""

# Model: no principal moment of inertia of a body is negative, and none exceeds the sum of the other
# two. Some public models have moments that no body has, of which each engine would make something
# else. Such a link has the mean of its moments about every axis, so that it depends on no axes. A
# link without mass weighs nothing. A link that a joint moves has at least the mass of a grain,
# because solvers divide by it.

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from cbdsl.kinematics.joint_tree import JointTree
from cbdsl.kinematics.pose import Pose, axis_of
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.urdf import UrdfInertial, UrdfModel

# Mass, kg, and moment of inertia, kg m^2, of a grain.
_LEAST_MASS, _LEAST_MOMENT = 1e-4, 1e-8


class LinkMass(NamedTuple):
    """Mass of a link.

    Attributes:
        mass: Mass, kg.
        frame: Centre of mass, and principal axes of inertia, in the link's frame.
        moments: Principal moments of inertia, kg m^2, shape (3,).
    """

    mass: float
    frame: Pose
    moments: Floats

    @property
    def inertia(self) -> Floats:
        """Inertia about the centre of mass, along the axes of the link, kg m^2, shape (3, 3)."""
        axes = self.frame.rotation
        inertia: Floats = axes * self.moments @ axes.T
        return inertia


_NOTHING = LinkMass(0.0, Pose(np.zeros(3), np.eye(3)), np.zeros(3))


def link_masses(model: UrdfModel) -> Mapping[str, LinkMass]:
    """Return the mass of each link of a model.

    Raises:
        UrdfError: A value of a link is not a number.
    """
    moved = {joint.child for joint in model.joints.values() if not joint.fixed}
    masses = {
        name: _NOTHING if link.inertial is None else _possible(link.inertial)
        for name, link in model.bodies.items()
    }
    return {name: _movable(of) if name in moved else of for name, of in masses.items()}


def moved_inertia(model: UrdfModel, joint: str, masses: Mapping[str, LinkMass]) -> float:
    """Return the inertia that a turning joint moves with all others at rest, kg m^2.

    Args:
        model: Model of the robot.
        joint: Name of the joint.
        masses: Masses of all links.
    """
    moved = model.joints[joint]
    # The tree begins at this joint, whose own place and position do not matter.
    tree = JointTree([moved._replace(parent="", child=moved.child), *model.beyond(moved.child)])
    placed = tree.place({**model.rests, joint: 0.0})
    frame = placed[moved.child].frame
    axis, inertia = frame.rotation @ axis_of(moved), 0.0
    for link, at in placed.items():
        of, pose = masses[link], at.child @ masses[link].frame
        lever = np.cross(axis, pose.position - frame.position)
        along = pose.rotation.T @ axis
        inertia += of.mass * float(lever @ lever) + float(along**2 @ of.moments)
    return inertia


def _possible(inertial: UrdfInertial) -> LinkMass:
    """Return the mass of a link with moments that a body can have."""
    xx, yy, zz, xy, xz, yz = inertial.inertia
    moments, axes = np.linalg.eigh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
    if moments[0] < 0.0 or moments[2] > moments[0] + moments[1]:
        moments = np.full(3, max(moments.mean(), 0.0))
    # Eigenvectors may form a left-handed frame, which is no rotation.
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    return LinkMass(inertial.mass, Pose.at(inertial.origin) @ Pose(np.zeros(3), axes), moments)


def _movable(of: LinkMass) -> LinkMass:
    return of._replace(
        mass=max(of.mass, _LEAST_MASS), moments=np.maximum(of.moments, _LEAST_MOMENT)
    )
