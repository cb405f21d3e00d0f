"""Context in which a controller's modifiers change its slot."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any, NamedTuple

from cbdsl.control.plan import SlotForm
from cbdsl.program.controller import Controller
from cbdsl.sensing.signals import Signals
from cbdsl.types.modifier import MODIFIERS, ModifierType, declared


class SlotSetting(NamedTuple):
    """Inputs of a modifier when a controller gets its slot.

    Attributes:
        controller: Controller of the slot.
        signals: Signals of the robot.
        period: Period of the control ticks, s.
    """

    controller: Controller
    signals: Signals
    period: float


def modified(form: SlotForm, setting: SlotSetting) -> SlotForm:
    """Return a slot as changed by all modifiers of its controller.

    Raises:
        PluginError: If a modifier of another package fails; the message names both.
    """
    for kind, options in declared(setting.controller):
        # Such a potential reads the option itself, so the modifier must not apply it a second time.
        if setting.controller.potential in kind.read_by:
            continue
        form = _bind_of(kind)(form, options, setting)
    for modifier in setting.controller.modifiers:
        kind = MODIFIERS.get(modifier.name)
        if not kind.slot:
            continue
        try:
            form = _changed(form, _bind_of(kind)(form, dict(modifier.options), setting))
        except Exception as error:
            raise MODIFIERS.fault(kind.name, f"{type(error).__name__}: {error}") from error
    return form


def _bind_of(kind: ModifierType) -> Callable[[SlotForm, Any, SlotSetting], SlotForm]:
    module, function = kind.slot.split(":")
    bind: Callable[[SlotForm, Any, SlotSetting], SlotForm] = getattr(
        import_module(module), function
    )
    return bind


def _changed(form: SlotForm, changed: object) -> SlotForm:
    """Return a changed slot, or refuse it if its type or number of coordinates is wrong.

    Raises:
        ValueError: If the type or the number of coordinates is wrong.
    """
    if not isinstance(changed, SlotForm):
        raise ValueError(f"it returns a {type(changed).__name__}, not a SlotForm")
    if len(changed.bounds) != len(form.bounds) or len(changed.settings) != len(form.settings):
        raise ValueError("its bounds or settings have another shape")
    return changed
