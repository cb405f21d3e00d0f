"""Contract of modifiers: functions of references and of slots."""

from __future__ import annotations

from importlib import import_module

import numpy as np
import pytest

from cbdsl.program.controller import Modifier
from cbdsl.runtime.controllers.preparation import change_of
from cbdsl.types.modifier import MODIFIERS
from cbdsl.types.resource_type import TYPES

CASES = [
    pytest.param(name, kind, id=f"{name}-{kind}")
    for name in MODIFIERS.usable_names()
    if MODIFIERS.get(name).implementation
    for kind in sorted(MODIFIERS.get(name).accepts)
]


@pytest.mark.parametrize("name", [n for n in MODIFIERS.usable_names() if MODIFIERS.get(n).slot])
def test_slot_modifier_has_its_function(name: str) -> None:
    module, function = MODIFIERS.get(name).slot.split(":")
    assert callable(getattr(import_module(module), function))


@pytest.mark.parametrize(("name", "kind"), CASES)
def test_reference_modifier_changes_references_of_its_types(name: str, kind: str) -> None:
    options = dict.fromkeys(MODIFIERS.get(name).options, 0.5)
    change = change_of(Modifier(name, tuple(options.items())))
    rng, size = np.random.default_rng(0), TYPES[kind].size
    reference, feedback = rng.normal(size=size), rng.normal(size=size)
    kept = reference.copy(), feedback.copy()
    for time in (0.0, 0.1, 7.3):
        changed = np.broadcast_to(change(reference, feedback, time, dict(options)), (size,))
        assert np.isfinite(changed).all()
        again = change(reference, feedback, time, dict(options))
        assert np.array_equal(changed, np.broadcast_to(again, (size,)))
    assert np.array_equal(reference, kept[0]) and np.array_equal(feedback, kept[1])
