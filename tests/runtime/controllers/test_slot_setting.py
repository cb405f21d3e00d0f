"""Modifiers of other packages change slots, and invalid slots are rejected."""

from __future__ import annotations

from types import SimpleNamespace as Made
from typing import Any

import numpy as np
import pytest

from cbdsl.control.plan import SlotForm
from cbdsl.program.controller import Modifier
from cbdsl.runtime.controllers import slot_setting
from cbdsl.runtime.controllers.slot_setting import SlotSetting, modified
from cbdsl.types.modifier import ModifierType

FORM = SlotForm(Made(), np.zeros(6), np.zeros(5), feedback=3, reference=4)  # type: ignore[arg-type]
FORCE = frozenset({"force"})
KINDS = {
    "rows": ModifierType("rows", "changes references alone", FORCE, implementation="a:b"),
    "slots": ModifierType("slots", "changes slots", FORCE, slot=f"{__name__}:bind"),
}


def bind(form: SlotForm, options: dict[str, float], setting: SlotSetting) -> Any:
    """Return another reference, no slot, or a slot of another shape, by the options."""
    assert setting.period == 0.125
    if "shape" in options:
        return form._replace(**{("bounds", "settings")[int(options["shape"])]: np.zeros(9)})
    return form._replace(reference=int(options["row"])) if "row" in options else "a slot"


@pytest.fixture(autouse=True)
def _offered(monkeypatch: pytest.MonkeyPatch) -> None:
    def fault(name: str, reason: str) -> Exception:
        return RuntimeError(f"{name}: {reason}")

    monkeypatch.setattr(slot_setting, "MODIFIERS", Made(get=KINDS.get, fault=fault))
    monkeypatch.setattr(slot_setting, "declared", lambda controller: controller.own)


def slot(*modifiers: Modifier, own: tuple[Any, ...] = (), potential: str = "spring") -> SlotForm:
    controller: Any = Made(modifiers=modifiers, own=own, potential=potential)
    return modified(FORM, SlotSetting(controller, Made(), 0.125))  # type: ignore[arg-type]


def test_slot_modifiers_apply_in_their_order() -> None:
    assert slot(Modifier("rows", ())) is FORM
    changed = slot(Modifier("rows", ()), Modifier("slots", (("row", 7),)))
    assert changed == FORM._replace(reference=7)
    assert slot(*(Modifier("slots", (("row", row),)) for row in (7, 8))).reference == 8


def test_option_read_by_its_potential_changes_no_slot() -> None:
    kind = KINDS["slots"]._replace(read_by=frozenset({"look_at"}))
    assert slot(own=((kind, {"row": 9}),), potential="look_at") is FORM
    assert slot(own=((kind, {"row": 9}),)).reference == 9


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ((), "it returns a str, not a SlotForm"),
        ((("shape", 0),), "its bounds or settings have another shape"),
        ((("shape", 1),), "its bounds or settings have another shape"),
    ],
)
def test_invalid_slot_of_a_modifier_is_refused(options: Any, reason: str) -> None:
    with pytest.raises(RuntimeError, match=f"slots: ValueError: {reason}"):
        slot(Modifier("slots", options))
