"""Contact constants of robot and objects."""

from __future__ import annotations

from typing import Any

from cbdsl.extend.backend import MujocoSection, Surface

# Impedance near and in a rigid contact, and the depth over which it grows, m.
_IMPEDANCE = [0.95, 0.99, 0.001, 0.5, 2.0]
# Exact Coulomb rolling friction of 0 makes the solver's cone flat, m.
_LEAST_ROLLING = 1e-5


class ContactSettings:
    """Contact constants of robot and objects.

    The friction of a pair is the larger one, except for movable objects, whose own friction counts.
    So a stage states how slippery an object is.

    Args:
        settings: Settings of the robot file.
    """

    def __init__(self, settings: MujocoSection) -> None:
        self._time, self._spinning = settings.contact_time, settings.spinning_friction

    def apply(self, geom: Any, friction: float) -> None:
        """Set the contact constants of a shape of the robot, with its lateral friction."""
        geom.friction = [friction, self._spinning, _LEAST_ROLLING]
        self._soften(geom)

    def apply_surface(self, geom: Any, surface: Surface, *, movable: bool) -> None:
        """Set the contact constants of a shape of an object; those of a movable object prevail."""
        given = surface.spinning_friction
        spinning = self._spinning if given is None else given
        rolling = max(surface.rolling_friction, _LEAST_ROLLING)
        geom.friction = [surface.friction, spinning, rolling]
        # MuJoCo takes the friction of the shape with the higher priority, and the larger one of
        # equals.
        geom.priority = int(movable)
        self._soften(geom)

    def _soften(self, geom: Any) -> None:
        geom.solref, geom.solimp = [self._time, 1.0], _IMPEDANCE
