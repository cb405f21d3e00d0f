"""Requirements: a controller is undefined unless another controller acts with it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.types.modifier import Call, ModifierType
from cbdsl.types.resource_type import TYPES

if TYPE_CHECKING:
    from cbdsl.control.plan import SlotForm
    from cbdsl.runtime.controllers.slot_setting import SlotSetting


def _read(text: str, call: Call) -> str | None:
    return call(text, "")


def bind(form: SlotForm, name: str, _: SlotSetting) -> SlotForm:
    """Return the slot of a controller that requires another."""
    return form._replace(requires=True)


REQUIRES = ModifierType(
    name="requires",
    summary="undefined without another controller",
    accepts=frozenset(TYPES),
    slot=f"{__name__}:bind",
    read=_read,
)
