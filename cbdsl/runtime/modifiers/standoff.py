"""Standoff: the control point in front of a tip, whose distance grows with the object's size."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.program.controller import Standoff
from cbdsl.types.modifier import Call, ModifierType, OptionFault
from cbdsl.types.resource import Tip
from cbdsl.types.source_record import owner_of

if TYPE_CHECKING:
    from cbdsl.control.plan import SlotForm
    from cbdsl.documents.program import StandoffSection
    from cbdsl.runtime.controllers.slot_setting import SlotSetting


def _read(section: StandoffSection, _: Call) -> Standoff:
    return Standoff(section.clearance, section.least, section.most)


def _fault(section: StandoffSection) -> OptionFault | None:
    if section.least <= section.most:
        return None
    ends = {"least": f"{section.least:g}", "most": f"{section.most:g}"}
    return OptionFault("least", "CB518", ends)


def bind(form: SlotForm, standoff: Standoff, setting: SlotSetting) -> SlotForm:
    """Return the slot of a controller whose feedback is the control point."""
    tip = Tip(owner_of(setting.controller.feedback.source), "position")
    row = setting.signals.kinematic_rows.tip_off(tip, form.reference, standoff)
    return form._replace(feedback=row)


STANDOFF = ModifierType(
    name="standoff",
    summary="keeps a tip in front of its reference, along its own normal",
    accepts=frozenset({"position"}),
    options={"clearance": "length", "least": "length", "most": "length"},
    slot=f"{__name__}:bind",
    sources=(Tip,),
    purpose="the position of a tip",
    read=_read,
    fault=_fault,
    not_negative=("clearance", "least", "most"),
)
