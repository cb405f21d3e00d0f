"""Numbers that control acts on, and refusing those that are not finite."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class SignalError(ValueError):
    """A number that control would act on is missing, misshapen or not finite; says which."""


def require_finite(values: Floats, name: str) -> None:
    """Refuse NaN and infinity before they reach a motor.

    Raises:
        SignalError: some of ``values`` is not finite; the message begins with their name.
    """
    if not np.isfinite(values).all():
        raise SignalError(f"{name} is not finite: {values.tolist()}")
