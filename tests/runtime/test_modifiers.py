"""Every modifier that packages add: a reference of the same shape, from its arguments alone."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.program.controller import Modifier
from cbdsl.runtime.preparation import change_of
from cbdsl.types.modifier import MODIFIERS
from cbdsl.types.resource_type import TYPES

CASES = [
    pytest.param(name, kind, id=f"{name}-{kind}")
    for name in MODIFIERS.usable_names()
    for kind in sorted(MODIFIERS.get(name).accepts)
]


@pytest.mark.parametrize(("name", "kind"), CASES)
def test_it_changes_references_of_the_types_that_it_accepts(name: str, kind: str) -> None:
    options = dict.fromkeys(MODIFIERS.get(name).options, 0.5)
    change = change_of(Modifier(name, tuple(options.items())))
    rng = np.random.default_rng(0)
    size = TYPES[kind].size
    reference, feedback = rng.normal(size=size), rng.normal(size=size)
    kept = reference.copy(), feedback.copy()
    for time in (0.0, 0.1, 7.3):
        changed = np.broadcast_to(change(reference, feedback, time, dict(options)), (size,))
        assert np.isfinite(changed).all()
        again = change(reference, feedback, time, dict(options))
        assert np.array_equal(changed, np.broadcast_to(again, (size,)))
    assert np.array_equal(reference, kept[0]) and np.array_equal(feedback, kept[1])
