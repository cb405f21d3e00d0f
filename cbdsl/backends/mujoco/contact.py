"""Contact constants of robot and objects."""

from __future__ import annotations

from typing import Any

from cbdsl.documents.robot import MujocoSection
from cbdsl.documents.stage import Surface

# Impedance near and in a rigid contact, and the depth over which it grows, m.
_IMPEDANCE = [0.95, 0.99, 0.001, 0.5, 2.0]
# Exact Coulomb rolling friction of 0 makes the solver's cone flat, m.
_LEAST_ROLLING = 1e-5


class ContactSettings:
    """Contact constants of robot and objects.

    The friction of a pair is the larger one, but for the objects that can be moved: these bring
    theirs along, so that a stage says how slippery a thing is.

    Args:
        settings: of the robot file.
    """

    def __init__(self, settings: MujocoSection) -> None:
        self._time, self._spinning = settings.contact_time, settings.spinning_friction

    def apply(self, geom: Any, friction: float) -> None:
        """Give a shape of the robot its constants, with a coefficient of lateral friction."""
        geom.friction = [friction, self._spinning, _LEAST_ROLLING]
        self._soften(geom)

    def apply_surface(self, geom: Any, surface: Surface, *, movable: bool) -> None:
        """Give a shape of an object its constants; of what can be moved they count."""
        given = surface.spinning_friction
        spinning = self._spinning if given is None else given
        rolling = max(surface.rolling_friction, _LEAST_ROLLING)
        geom.friction = [surface.friction, spinning, rolling]
        geom.priority = int(movable)
        self._soften(geom)

    def _soften(self, geom: Any) -> None:
        geom.solref, geom.solimp = [self._time, 1.0], _IMPEDANCE
