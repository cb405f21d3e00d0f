"""Free axis: an orientation is compared in the tip's two other axes only."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.types.modifier import ModifierType

if TYPE_CHECKING:
    from cbdsl.control.plan import SlotForm
    from cbdsl.runtime.controllers.slot_setting import SlotSetting


def bind(form: SlotForm, axis: str, setting: SlotSetting) -> SlotForm:
    """Return the slot of a spring that lets the tip turn about an axis."""
    from cbdsl.control.potentials.spring import spring

    kind = setting.controller.feedback.type
    turned = spring(kind.name, kind.size, axis)
    return form._replace(potential=turned, spin="xyz".index(axis))


FREE_AXIS = ModifierType(
    name="free_axis",
    summary="lets a tip turn about one of its axes",
    accepts=frozenset({"orientation"}),
    slot=f"{__name__}:bind",
    purpose="orientations",
    read_by=frozenset({"look_at"}),
)
