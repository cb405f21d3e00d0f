"""Control law, potentials and measures of a posture, without a program.

Postures are rad or m, shape (n,); Jacobians have one row per dimension of the space.
"""

from __future__ import annotations

from cbdsl.control.law import Law, LawSettings
from cbdsl.control.level import Level
from cbdsl.control.potential import Potential, Rule

# Short names of functions are clear only beside their modules, such as `range.between`.
from cbdsl.control.potentials.localizability import seen_by as localizability_potential
from cbdsl.control.potentials.manipulability import of_jacobian as manipulability_potential
from cbdsl.control.potentials.range import between as range_potential
from cbdsl.control.potentials.spring import spring as spring_potential
from cbdsl.kinematics.kinematics import Frame, Kinematics
from cbdsl.kinematics.rotation import log as rotation_vector
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.urdf import UrdfModel
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.sensing.table.tips import Tips

__all__ = [
    "Floats", "Frame", "Kinematics", "Law", "LawSettings", "Level", "Potential", "Rule",
    "Tips", "UrdfModel", "localizability_potential", "manipulability_potential",
    "range_potential", "read_urdf", "rotation_vector", "spring_potential",
]  # fmt: skip
