"""Nominal types of sensory and motor signals (Table 3.1)."""

import math
from collections.abc import Sequence
from typing import NamedTuple, Self

# Errors within which a controller at rest has arrived, by SI unit. They exceed the noise of cameras
# and servos, and the error at which common criteria of rest hold during an approach. A force has
# none: the stiffness of the contact determines at which force it rests.
_ARRIVALS = {"m": 0.02, "rad": math.radians(5.0)}
# Slides of fingers are shorter than the ways of tips.
_SLIDE_ARRIVAL = 0.005


class ResourceType(NamedTuple):
    """Type of the quantity that a resource carries.

    Types are nominal: a force is not a position although both live in R^3.

    Attributes:
        name: Type name as printed in diagnostics, without its size.
        space: Mathematical space, in the notation of Table 3.1.
        dimension: Number of components of one value (of the tangent space for SO(3) and SE(3)).
        unit: SI units, separated by commas; each is the unit of an equal share of the components.
            A configuration of turning and sliding joints has one for each joint.
        factors: Number of copies of the type in a product; 1 for a plain type.
    """

    name: str
    space: str
    dimension: int
    unit: str
    factors: int = 1

    def times(self, factors: int) -> Self:
        """Return the product of ``factors`` copies of this type."""
        return self._replace(factors=self.factors * factors)

    @property
    def size(self) -> int:
        """Number of components of one value, over all factors."""
        return self.dimension * self.factors

    @property
    def units(self) -> tuple[str, ...]:
        """SI unit of each component of one value, over all factors."""
        listed = self.unit.split(", ")
        share = self.dimension // len(listed)
        return tuple(unit for unit in listed for _ in range(share)) * self.factors

    @property
    def arrivals(self) -> tuple[float, ...]:
        """Default error of an arrived controller for each unit; infinite for other quantities."""
        own = _ARRIVALS | ({"m": _SLIDE_ARRIVAL} if self.name == "configuration" else {})
        units = dict.fromkeys(self.unit.split(", "))
        return tuple(own.get(unit, math.inf) for unit in units)

    def apart_from(self, other: Self) -> str:
        """Return the type as text, with its units if it differs from another type in them alone."""
        return f"{self} in {self.unit}" if str(self) == str(other) else str(self)

    def __str__(self) -> str:
        own = f"{self.name}[{self.dimension}]" if self.name == "configuration" else self.name
        return own if self.factors == 1 else f"{own} x {self.factors}"


#: Unit of a joint that a model does not have, and of ``configuration`` in general.
ANGLE_OR_LENGTH = "rad or m"


def configuration(joints: int, units: Sequence[str] = ("rad",)) -> ResourceType:
    """Return the type of joint variables, C_n.

    Args:
        joints: Number of joints.
        units: Unit of each joint's position, or one for all.
    """
    # Mixed joints have one unit each, as in ``rad, m`` for a rotary joint with a slide.
    unit = units[0] if len(set(units)) == 1 else ", ".join(units)
    return ResourceType("configuration", f"C_{joints}", joints, unit)


WRENCH = ResourceType("wrench", "SE*(3)", 6, "N, N m")
FORCE = ResourceType("force", "R^3", 3, "N")
TORQUE = ResourceType("torque", "SO*(3)", 3, "N m")
# Table 3.1 says SO(2), yet a heading has two angles (the image centre is [0 0]).
HEADING = ResourceType("heading", "SO(2)^2", 2, "rad")
POSE = ResourceType("pose", "SE(3)", 6, "m, rad")
POSITION = ResourceType("position", "R^3", 3, "m")
ORIENTATION = ResourceType("orientation", "SO(3)", 3, "rad")
VELOCITY = ResourceType("velocity", "R^3", 3, "m/s")
VOLUME = ResourceType("volume", "R+", 1, "m^3")
COUNT = ResourceType("count", "N", 1, "")
PROBABILITY = ResourceType("probability", "[0, 1]", 1, "")
HEADING_RATE = ResourceType("heading_rate", "R^2", 2, "rad/s")
# Axes du and dv of a blob (Fig 7.15), along and across its orientation.
EXTENT = ResourceType("extent", "R+^2", 2, "rad")
# An axis has no direction: its angle is the same after half a turn.
AXIS = ResourceType("axis", "RP^1", 1, "rad")
# Ratios of two blobs' axes and the angle between them (Fig 7.15); all are numbers.
CONSTELLATION = ResourceType("constellation", "R+^2 x RP^1", 3, "1")
# Vector from one object to another, in world axes.
OFFSET = ResourceType("offset", "R^3", 3, "m")
# Distance of an object from the base of an effector.
DISTANCE = ResourceType("distance", "R+", 1, "m")
# Share of a known pair's observations that are farther from their mean than the present one.
LIKENESS = ResourceType("likeness", "[0, 1]", 1, "")
# Extent of an object, or opening of a hand.
LENGTH = ResourceType("length", "R+", 1, "m")

#: All types, by name: those of Table 3.1, where ``configuration`` stands for every C_n, and those
#: of features that are derived from images (Section 5.3, Fig 7.15).
TYPES: dict[str, ResourceType] = {
    kind.name: kind
    for kind in (
        ResourceType("configuration", "C_n", 0, ANGLE_OR_LENGTH),
        WRENCH, FORCE, TORQUE, HEADING, POSE, POSITION, ORIENTATION, VELOCITY, VOLUME, COUNT,
        PROBABILITY, HEADING_RATE, EXTENT, AXIS, CONSTELLATION, OFFSET, LENGTH, DISTANCE, LIKENESS,
    )
}  # fmt: skip
