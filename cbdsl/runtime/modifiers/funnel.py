"""Funnel: an approach from above, whose height grows with the lateral error."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.program.controller import Funnel
from cbdsl.types.modifier import Call, ModifierType
from cbdsl.types.resource import GraspCentre, Tip

if TYPE_CHECKING:
    from cbdsl.control.plan import SlotForm
    from cbdsl.documents.program import FunnelSection
    from cbdsl.runtime.controllers.slot_setting import SlotSetting


def _read(section: FunnelSection, _: Call) -> Funnel:
    return Funnel(section.height, section.within, section.slope)


def bind(form: SlotForm, funnel: Funnel, _: SlotSetting) -> SlotForm:
    """Return the slot of a controller that approaches from above."""
    return form._replace(funnel=funnel)


FUNNEL = ModifierType(
    name="funnel",
    summary="comes to the reference from above",
    accepts=frozenset({"position"}),
    options={"height": "length", "within": "length", "slope": ""},
    slot=f"{__name__}:bind",
    sources=(Tip, GraspCentre),
    purpose="the position of a tip or of a grasp",
    residual=True,
    read=_read,
    positive=("height",),
    not_negative=("within",),
)
