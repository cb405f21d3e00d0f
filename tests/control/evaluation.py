"""Potentials by the joints: the signals of a test, and the evaluations by a potential."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cbdsl.control.potential import Potential, Rule, interpreted
from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.table.reading import flattened
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
    in_python: bool = False,
) -> Evaluation:
    """Evaluate a potential's function, compiled or, with bounds checked, interpreted."""
    goal = np.zeros(0) if reference is None else flat(reference)
    function = interpreted(potential.function) if in_python else potential.function
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


def gradient(potential: str, evaluation: Evaluation) -> Floats:
    """Return the gradient of phi by the joints."""
    if POTENTIALS[potential].residual:
        slope: Floats = -evaluation.jacobian.T @ evaluation.residual
        return slope
    row: Floats = evaluation.jacobian[0]
    return row


def flat(value: Floats) -> Floats:
    """Return a value as a row of the signal table."""
    return flattened(value, "pose" if value.shape == (4, 4) else "").astype(np.float64)
