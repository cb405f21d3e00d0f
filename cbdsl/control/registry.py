"""The implementations of the potentials, by the names that programs use."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from cbdsl.control.body import Body
from cbdsl.control.harmonic import Harmonic
from cbdsl.control.localizability import Localizability
from cbdsl.control.manipulability import Manipulability
from cbdsl.control.potential import Potential
from cbdsl.control.range import Range
from cbdsl.control.spring import Spring
from cbdsl.program.controller import Controller

Builder = Callable[[Controller, Body], Potential]
"""Makes the potential of a controller for a body."""

#: One line per entry of ``cbdsl.types.potential.POTENTIALS``.
IMPLEMENTATIONS: Mapping[str, Builder] = MappingProxyType(
    {
        "spring": Spring.build,
        "range": Range.build,
        "manipulability": Manipulability.build,
        "localizability": Localizability.build,
        "harmonic": Harmonic.build,
    }
)


def build(controller: Controller, body: Body) -> Potential:
    """The potential of a checked controller.

    Args:
        controller: names the potential and the type of its feedback.
        body: what ``controller.joints`` belong to.

    Raises:
        ValueError: the body lacks what the potential needs, such as joint limits or cameras.
    """
    return IMPLEMENTATIONS[controller.potential](controller, body)
