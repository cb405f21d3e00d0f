"""Physically impossible masses, moments of inertia and shapes of a model."""

from __future__ import annotations

import math
from collections.abc import Iterator

from cbdsl.robot.urdf import Numbers, UrdfInertial, UrdfJoint, UrdfLink, UrdfModel, UrdfShape

# Tolerance of the bounds on principal moments for rounding, as a share of the largest moment.
_ROUNDING = 0.02
# Radius of gyration, m, beyond which moments are implausible, such as moments in kg mm^2.
_LARGEST = 20.0
# Largest distance, m, mass, kg, and length of an axis; ten turns, and the smallest range and speed.
_FARTHEST, _HEAVIEST, _LONGEST_AXIS = 1e3, 1e6, 1e3
_MOST_RADIANS, _LEAST = 20.0 * math.pi, 1e-6
# Largest moment, kg m^2, that can be computed with.
_MOST = 1e100


def odd_inertias(model: UrdfModel) -> Iterator[tuple[str, str]]:
    """Yield links with moments of inertia that no rigid body has, each with the reason.

    The principal moments of a body are positive, because each is the integral of the squared
    distance from an axis. None exceeds the sum of the other two. Links fixed to others, and links
    without mass, may have none.

    Raises:
        UrdfError: If a value of a link is not a number.
    """
    moved = {joint.child for joint in model.joints.values() if not joint.fixed}
    for name, link in model.bodies.items():
        if link.inertial is not None and link.inertial.mass > 0.0:
            reason = _oddness(link.inertial, name in moved)
            if reason:
                yield name, reason


def _oddness(inertial: UrdfInertial, moved: bool) -> str:
    """Return the reason why moments of inertia are impossible; empty if they are not."""
    if not any(inertial.inertia):
        return f"a mass of {inertial.mass:g} kg and no moment of inertia" if moved else ""
    if max(map(abs, inertial.inertia)) > _MOST:
        return f"a moment of inertia beyond {_MOST:g} kg m^2"
    # The bound on the largest moment follows from I1 + I2 - I3 = 2 * integral of z^2 dm, which is
    # not negative. It holds with equality for a flat plate.
    least, middle, most = principal_moments(inertial.inertia)
    if least < -_ROUNDING * abs(most) or most <= 0.0:
        return f"a principal moment of inertia of {least:.3g} kg m^2"
    if most > (1.0 + _ROUNDING) * (least + middle):
        return (
            f"a principal moment of inertia of {most:.3g} kg m^2, "
            f"more than the sum of the others, {least + middle:.3g} kg m^2"
        )
    # A moment is m k^2. The radius of gyration k is at most the largest distance of the body's mass
    # from the axis.
    radius = math.sqrt(most / inertial.mass)
    return f"a radius of gyration of {radius:.3g} m" if radius > _LARGEST else ""


def odd_numbers(model: UrdfModel) -> Iterator[tuple[str, str]]:
    """Yield joints and links with numbers that no robot has, each with the reason.

    Engines compute with them, and their results are wrong or not finite.

    Raises:
        UrdfError: If a value of a link is not a number.
    """
    for name, joint in model.joints.items():
        reason = _odd_joint(joint)
        if reason:
            yield name, reason
    for name, link in model.bodies.items():
        if link.inertial is not None and link.inertial.mass > _HEAVIEST:
            yield name, f"a mass of {link.inertial.mass:g} kg"


def _odd_joint(joint: UrdfJoint) -> str:
    """Return the first number of a joint that no robot has; empty if all are plausible."""
    distance, axis = math.hypot(*joint.origin.xyz), math.hypot(*joint.axis)
    if distance > _FARTHEST:
        return f"a distance of {distance:.3g} m from its parent"
    if not joint.movable:
        return ""
    if axis > 0.0 and not 1.0 / _LONGEST_AXIS < axis < _LONGEST_AXIS:
        return f"an axis of length {axis:.3g}"
    ends = [abs(end) for end in (joint.lower, joint.upper) if math.isfinite(end)]
    if max(ends, default=0.0) > (_FARTHEST if joint.slides else _MOST_RADIANS):
        hint = "" if joint.slides else ", as if in degrees"
        return f"limits of {joint.lower:g} to {joint.upper:g} {joint.unit}{hint}"
    if 0.0 < joint.velocity < _LEAST or 0.0 < joint.upper - joint.lower < _LEAST:
        return f"a range or speed below {_LEAST:g} {joint.unit}"
    return ""


def principal_moments(inertia: Numbers) -> tuple[float, float, float]:
    """Return the eigenvalues of a matrix of inertia, the smallest first.

    The solution is in closed form (Smith 1961). Shifted by its mean and scaled, a symmetric matrix
    of three rows has the eigenvalues 2 cos(angle + 2 k pi / 3), with cos(3 angle) half its
    determinant. Documents are thus checked without NumPy, which the base installation lacks.

    Args:
        inertia: Moments xx, yy, zz, xy, xz and yz, kg m^2.
    """
    xx, yy, zz, xy, xz, yz = inertia
    mean = (xx + yy + zz) / 3.0
    scale = math.sqrt(
        ((xx - mean) ** 2 + (yy - mean) ** 2 + (zz - mean) ** 2) / 6.0
        + (xy**2 + xz**2 + yz**2) / 3.0
    )
    if scale == 0.0:
        return mean, mean, mean
    a, b, c = ((each - mean) / scale for each in (xx, yy, zz))
    d, e, f = xy / scale, xz / scale, yz / scale
    determinant = a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e)
    # Rounding can move the cosine of matrices with two equal eigenvalues slightly out of its range.
    angle = math.acos(min(max(determinant / 2.0, -1.0), 1.0)) / 3.0
    most = mean + 2.0 * scale * math.cos(angle)
    least = mean + 2.0 * scale * math.cos(angle + 2.0 * math.pi / 3.0)
    return least, 3.0 * mean - most - least, most


def flat_shapes(model: UrdfModel) -> Iterator[tuple[str, str]]:
    """Yield links with a shape that has no volume, each with the shape.

    Raises:
        UrdfError: If a value of a link is not a number.
    """
    for name, link in model.bodies.items():
        shape = next(_flat(link), None)
        if shape is not None:
            size = " ".join(f"{extent:g}" for extent in shape.size)
            kind = "scaled mesh" if shape.kind == "mesh" else shape.kind
            yield name, f"a {kind} of size {size}"


def _flat(link: UrdfLink) -> Iterator[UrdfShape]:
    for shape in (*link.collisions, *link.visuals):
        # A negative scale mirrors a mesh.
        extents = map(abs, shape.size) if shape.kind == "mesh" else shape.size
        if any(extent <= 0.0 for extent in extents):
            yield shape
