"""Potentials by the joints: what a test measures, and what a potential makes of it."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np
from numba.core.dispatcher import Dispatcher

from cbdsl.control.potential import Potential, Rule
from cbdsl.control.signal import Floats
from cbdsl.sensing.reading import flattened
from cbdsl.types.potential import POTENTIALS


class Signal(NamedTuple):
    """A measured value in the form of its type, and its Jacobian as a row of the table has it."""

    value: Floats
    jacobian: Floats


class Evaluation(NamedTuple):
    """A potential in task coordinates: residual (k,), coordinates per joint (k, n), step (k,)."""

    phi: float
    residual: Floats
    jacobian: Floats
    step: Floats


def evaluate(
    potential: Potential,
    signal: Signal,
    reference: Floats | None = None,
    *,
    interpreted: bool = False,
) -> Evaluation:
    """A potential by its function alone, compiled or, with bounds checked, interpreted."""
    goal = np.zeros(0) if reference is None else flat(reference)
    function = in_python(potential.function) if interpreted else potential.function
    residual, slope = np.zeros(potential.size), np.zeros((potential.size, len(signal.jacobian)))
    phi = function(flat(signal.value), goal, potential.parameters, residual, slope)
    if potential.identity:
        assert not slope.any()
        slope[:] = np.eye(potential.size)
    jacobian = slope @ signal.jacobian
    if potential.rule == Rule.DESCENT:
        residual[0] = -float(jacobian[0] @ jacobian[0])
    step = 0.5 * residual if potential.rule == Rule.RESIDUAL else residual
    return Evaluation(float(phi), residual, jacobian, step)


@cache
def in_python(function: Any) -> Callable[..., Any]:
    """The function that was compiled, and all that it calls, as Python runs them."""
    source = function.py_func
    scope = dict(source.__globals__)
    for name in source.__code__.co_names:
        if isinstance(scope.get(name), Dispatcher):
            scope[name] = in_python(scope[name])
    return FunctionType(source.__code__, scope, source.__name__, None, source.__closure__)


def gradient(potential: str, evaluation: Evaluation) -> Floats:
    """Of phi by the joints."""
    if POTENTIALS[potential].residual:
        slope: Floats = -evaluation.jacobian.T @ evaluation.residual
        return slope
    return evaluation.jacobian[0]


def flat(value: Floats) -> Floats:
    """A value as a row of the signal table has it."""
    return flattened(value, "pose" if value.shape == (4, 4) else "").astype(np.float64)
