"""Modifiers of controllers, for the entry-point group ``cbdsl.modifiers``.

An entry is a ``ModifierType`` with the accepted types and the options, for the checker. It names a
``ReferenceFunction``, called in every tick, or a ``SlotFunction``, called when a controller gets
its slot in the plan. An exception, or another result, ends the run with the name of the package.
The contract test is ``cbdsl.extend.contract.test_modifier``.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol

from cbdsl.extend.lazy_names import lazy_names

if TYPE_CHECKING:
    from cbdsl.control.plan import SlotForm
    from cbdsl.numeric.arrays import Floats
    from cbdsl.runtime.controllers.slot_setting import SlotSetting
    from cbdsl.types.modifier import ModifierType, OptionFault

__all__ = [
    "Floats", "ModifierType", "OptionFault", "ReferenceFunction", "SlotForm", "SlotFunction",
    "SlotSetting",
]  # fmt: skip

__getattr__ = lazy_names(__file__)


class ReferenceFunction(Protocol):
    """Function ``implementation`` of a modifier that changes references."""

    def __call__(
        self, reference: Floats, feedback: Floats, time: float, options: Mapping[str, float]
    ) -> Floats:
        """Return the changed reference, shape (m,), and leave the arguments as they are.

        Args:
            reference: Value of the reference, SI, shape (m,).
            feedback: Value of the feedback, SI, shape (m,).
            time: Simulated time, s.
            options: Options of the program by name, SI.
        """
        ...


class SlotFunction(Protocol):
    """Function ``slot`` of a modifier that changes a controller's slot in the plan."""

    def __call__(
        self, form: SlotForm, options: Mapping[str, float], setting: SlotSetting
    ) -> SlotForm:
        """Return the changed slot.

        Args:
            form: Constants of the slot.
            options: Options of the program by name, SI.
            setting: Controller, signals and control period.
        """
        ...
