"""Search over postures for the least error of a controller."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.numeric.arrays import Floats
from cbdsl.runtime.controllers.controller_run import ControllerRun
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.table.refresh import CONFIGURATION, LENGTH, MIXTURE, TIP
from cbdsl.types.potential import POTENTIALS

# Rows whose values follow from the posture alone.
_KINEMATIC = (CONFIGURATION, TIP, MIXTURE, LENGTH)

# Starts of the search, and evaluations from each. Descents from random postures find a reachable
# pose in more than a third of the cases, so that all of them miss it in one of ten thousand.
_STARTS, _EVALUATIONS = 24, 60

# Range of the starts of joints without limits, rad or m.
_RANGE = math.pi


# The error is a sum of squares, so that a trust region descends it from each start, with the rows
# of the signal table as its Jacobian. The reference and other joints than the effector's stay.
def least_error(run: ControllerRun, signals: Signals, margin: float) -> float:
    """Return the least error that a controller has in any posture of its effector.

    The search ends at the first posture in which the controller would have arrived.

    Args:
        run: Run of a controller that is defined.
        signals: Signals that it reads; they are the same afterwards.
        margin: Distance of joints from their limits, rad or m.

    Returns:
        Error in the unit of the feedback; NaN if it does not follow from the posture alone.
    """
    from scipy.optimize import least_squares  # only the end of an episode needs it

    selection = signals.select([run.rows.feedback])._replace(read=())
    if not _is_kinematic(run, signals):
        return math.nan
    own, kinematics = run.own, signals.kinematics
    here = kinematics.positions.copy()
    lower, upper = kinematics.lower[own] + margin, kinematics.upper[own] - margin
    first, last = np.maximum(lower, here[own] - _RANGE), np.minimum(upper, here[own] + _RANGE)

    def pose(q: Floats) -> tuple[Floats, Floats]:
        posture = here.copy()
        posture[own] = q
        kinematics.update(posture)
        signals.refresh(selection)
        evaluation = run.evaluate(own)
        assert evaluation is not None
        return evaluation.residual, -evaluation.jacobian

    rng, least = np.random.default_rng(0), run.error
    for _ in range(_STARTS):
        if least <= run.controller.arrival[0]:
            break
        start = rng.uniform(first, last)
        descent = least_squares(
            lambda q: pose(q)[0], start, lambda q: pose(q)[1], (lower, upper),
            max_nfev=_EVALUATIONS,
        )  # fmt: skip
        least = min(least, math.sqrt(2.0 * descent.cost))
    kinematics.update(here)
    signals.refresh(selection)
    return float(least)


def _is_kinematic(run: ControllerRun, signals: Signals) -> bool:
    """Return whether the feedback, and it alone, follows from the posture."""
    if not POTENTIALS[run.controller.potential].residual or math.isnan(run.error):
        return False
    kinds = signals.table.records["kind"]
    feedback = kinds[signals.select([run.rows.feedback]).compiled]
    reference = kinds[signals.select([row for row in run.rows[:2] if row >= 0]).compiled]
    return bool(np.isin(feedback, _KINEMATIC).all() and not np.isin(reference, _KINEMATIC).any())
