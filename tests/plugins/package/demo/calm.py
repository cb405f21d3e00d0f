"""Modifier that slows a controller down."""

from collections.abc import Mapping

from cbdsl.extend.modifier import ModifierType, SlotForm, SlotSetting

CALM = ModifierType(
    name="calm",
    summary="a share of gain and speed",
    accepts=frozenset({"position"}),
    options={"share": ""},
    slot="demo.calm:bind",
)


def bind(form: SlotForm, options: Mapping[str, float], setting: SlotSetting) -> SlotForm:
    """Return the slot of a controller with a share of its gain and its speed."""
    bounds = form.bounds.copy()
    bounds[:2] *= options["share"]
    return form._replace(bounds=bounds)
