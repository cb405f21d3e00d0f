"""The implementations of the potentials, by the names that programs use."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from cbdsl.control.potential import Potential
from cbdsl.control.range import Range
from cbdsl.control.signal import Floats
from cbdsl.control.spring import Spring
from cbdsl.program.controller import Controller

Builder = Callable[[Controller, Floats, Floats], Potential]
"""Makes the potential of a controller, given the lower and upper limits of its joints, rad."""

#: One line per entry of ``cbdsl.types.potential.POTENTIALS``.
IMPLEMENTATIONS: Mapping[str, Builder] = MappingProxyType(
    {
        "spring": Spring.build,
        "range": Range.build,
    }
)


def build(controller: Controller, lower: Floats, upper: Floats) -> Potential:
    """The potential of a checked controller.

    Args:
        controller: names the potential and the type of its feedback.
        lower: lower limits of ``controller.joints``, rad.
        upper: upper limits of ``controller.joints``, rad.
    """
    return IMPLEMENTATIONS[controller.potential](controller, lower, upper)
