"""Functions that are none of a potential are named when a controller gets its slot."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numba import njit

from cbdsl.control.conditions.predicate import settings_of
from cbdsl.control.plan import ControllerPlan, SlotForm
from cbdsl.control.potential import (
    Potential,
    PotentialError,
    address_of,
    interpreted,
    potential,
)
from cbdsl.numeric.compiled import compiled


def plain(value: Any, reference: Any, parameters: Any, residual: Any, slope: Any) -> float:
    return 0.0


@potential
def short(value: Any, reference: Any, residual: Any) -> float:
    return 0.0


@potential
def whole(value: Any, reference: Any, parameters: Any, residual: Any, slope: Any) -> int:
    return 1


@potential
def empty(value: Any, reference: Any, parameters: Any, residual: Any, slope: Any) -> None:
    residual[0] = 1.0


@potential
def untyped(value: Any, reference: Any, parameters: Any, residual: Any, slope: Any) -> float:
    return value.no_such_thing()


@njit("float32(float64[::1], float64[::1], float64[::1], float64[::1], float64[:, ::1])")
def single(value: Any, reference: Any, parameters: Any, residual: Any, slope: Any) -> float:
    return 1.0


WRONG = {
    "plain": (plain, "is not compiled: decorate it with @potential"),
    "short": (short, "cannot be compiled"),
    "whole": (whole, "returns int64, not a float"),
    "empty": (empty, "returns none, not a float"),
    "untyped": (untyped, "cannot be compiled"),
    "single": (single, "cannot be compiled: compilation disabled"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_potential_is_refused_with_name_and_reason(name: str) -> None:
    function, message = WRONG[name]
    with pytest.raises(PotentialError, match=f"^potential '{name}' .*{message}"):
        address_of(function)


@pytest.mark.parametrize("name", WRONG)
def test_plan_refuses_every_wrong_potential(name: str) -> None:
    plan = ControllerPlan()
    function: Callable[..., Any] = WRONG[name][0]
    settings = settings_of(1e-3, 0.3, 0.01)
    form = SlotForm(Potential(function, 1), np.zeros(6), settings, 0, -1, (0.0,) * 3, None, False)
    with pytest.raises(PotentialError):
        plan.add(form)
    assert len(plan.slots) == 0
    assert plan.version == 0


@compiled
def put(vector: Any, place: int) -> None:
    vector[place] = 1.0


@potential
def beyond(value: Any, reference: Any, parameters: Any, residual: Any, slope: Any) -> float:
    put(residual, len(residual))
    return 0.0


def test_interpreted_an_index_beyond_an_array_is_an_error_in_helpers_too() -> None:
    """Compiled, it would write there."""
    with pytest.raises(IndexError):
        interpreted(beyond)(*[np.zeros(2)] * 4, np.zeros((2, 2)))
