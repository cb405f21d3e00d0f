"""Numbers that control acts on, and the rejection of non-finite ones."""

from __future__ import annotations

import numpy as np

from cbdsl.numeric.arrays import Floats


class SignalError(ValueError):
    """Missing, misshapen or non-finite number for control; the message names it."""


def require_finite(values: Floats, name: str) -> None:
    """Reject NaN and infinity before they reach a motor.

    Raises:
        SignalError: If some of ``values`` are not finite; the message begins with their name.
    """
    if not np.isfinite(values).all():
        raise SignalError(f"{name} is not finite: {values.tolist()}")
