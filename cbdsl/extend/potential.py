"""Potentials, for the entry-point group ``cbdsl.potentials``.

An entry is a ``PotentialType``: the accepted types, for the checker, and the place of a function
``(Controller, Setting) -> Potential``, called once a run. A ``Potential`` has a function compiled
by ``@potential``; that decorator states its arguments and their shapes. It returns NaN for a value
for which it is undefined. ``PotentialError`` names a function with other arguments. The contract
test is ``cbdsl.extend.contract.test_potential``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.extend.lazy_names import lazy_names

if TYPE_CHECKING:
    from cbdsl.control.potential import Potential, PotentialError, Rule, potential
    from cbdsl.control.setting import Setting
    from cbdsl.numeric.arrays import Floats
    from cbdsl.program.controller import Controller
    from cbdsl.types.potential import Condition, Navigation, PotentialType
    from cbdsl.types.resource_type import TYPES, ResourceType

__all__ = [
    "TYPES", "Condition", "Controller", "Floats", "Navigation", "Potential", "PotentialError",
    "PotentialType", "ResourceType", "Rule", "Setting", "potential",
]  # fmt: skip

__getattr__ = lazy_names(__file__)
