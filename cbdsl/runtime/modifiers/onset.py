"""Onset: a controller of a load is undefined until the load has changed."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from cbdsl.program.controller import Onset
from cbdsl.types.modifier import Call, ModifierType
from cbdsl.types.resource import Tip
from cbdsl.types.resource_type import TYPES
from cbdsl.types.source_record import owner_of

if TYPE_CHECKING:
    from cbdsl.control.plan import SlotForm
    from cbdsl.documents.program import OnsetSection
    from cbdsl.runtime.controllers.slot_setting import SlotSetting


def _read(section: OnsetSection, _: Call) -> Onset:
    return Onset(*(getattr(section, key) for key in Onset._fields))


def bind(form: SlotForm, onset: Onset, setting: SlotSetting) -> SlotForm:
    """Return the slot of a controller that waits for a load change along its displacement."""
    from cbdsl.control.conditions.onset import OnsetForm

    signals = setting.signals
    carrier = signals.touch.carriers.get(owner_of(setting.controller.feedback.source))
    tip = -1
    if carrier is not None:
        tip = signals.kinematic_rows.tip_off(Tip(carrier, "position"), -1, (0.0, 0.0, 0.0))
    # The change of the load counts along the displacement only.
    offset = signals.table.values(form.offset)
    along = offset / math.hypot(*offset.tolist())
    borne = -math.inf if onset.borne is None else onset.borne
    form_of_load = OnsetForm(
        onset.change, along, onset.window, onset.pace, tip, setting.period, borne, onset.lifted
    )
    return form._replace(onset=form_of_load)


ONSET = ModifierType(
    name="onset",
    summary="undefined until a load has changed",
    # The check of its reference restricts the types of loads.
    accepts=frozenset(TYPES),
    options={
        "change": "force",
        "window": "time",
        "pace": "speed",
        "borne": "force",
        "lifted": "length",
    },
    slot=f"{__name__}:bind",
    read=_read,
    positive=("pace",),
    not_negative=("lifted",),
)
