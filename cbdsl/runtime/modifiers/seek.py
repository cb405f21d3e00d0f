"""Seeking: a controller acts although its feedback is undefined, for example to find contact."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from cbdsl.program.controller import Seek
from cbdsl.types.modifier import Call, ModifierType
from cbdsl.types.resource import FingerForces, NetForces, NetLoad
from cbdsl.types.source_record import owner_of

if TYPE_CHECKING:
    from cbdsl.control.plan import SlotForm
    from cbdsl.documents.program import SeekSection
    from cbdsl.runtime.controllers.slot_setting import SlotSetting


def _read(section: SeekSection, call: Call) -> Seek:
    return Seek(call(section.once, "once"), section.within, section.until)


def bind(form: SlotForm, seek: Seek, setting: SlotSetting) -> SlotForm:
    """Return the slot of a controller that seeks, without end or until the fingers have closed."""
    from cbdsl.control.plan import Search

    search = Search(seek.once is not None, seek.within, math.nan, ())
    if seek.until is not None:
        hand, touch = owner_of(setting.controller.feedback.source), setting.signals.touch
        joints, closing = touch.flexing[hand].tolist(), touch.closing[hand]
        search = Search(search.follows, seek.within, seek.until, joints, closing)
    return form._replace(search=search)


SEEK = ModifierType(
    name="seek",
    summary="acts although the feedback is undefined, until it is defined",
    accepts=frozenset({"force"}),
    options={"once": "", "within": "length", "until": "angle"},
    slot=f"{__name__}:bind",
    sources=(FingerForces, NetForces, NetLoad),
    purpose="forces of fingers or hands",
    read=_read,
    positive=("within",),
)
