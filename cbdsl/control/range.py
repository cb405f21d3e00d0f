"""The range-limit potential (Section 3.1.3 a, Eq 3.3 and 3.4)."""

from __future__ import annotations

import numpy as np

from cbdsl.control.body import Body
from cbdsl.control.potential import Evaluation, half_square
from cbdsl.control.signal import Floats, Signal, SignalError
from cbdsl.program.controller import Controller


class Range:
    """phi = sum_i 1 - cos g_i, with g_i from -pi/2 to pi/2 between a joint's limits.

    Since 1 - cos g = (2 sin(g/2))^2 / 2, phi is half the square of r_i = 2 sin(g_i / 2). Those
    coordinates have a Jacobian of full rank at the centre, where the gradient of phi vanishes.

    Args:
        lower: lower limits of the feedback's joints, rad, shape (m,).
        upper: upper limits, rad, shape (m,).

    Raises:
        ValueError: a range is empty or has no end.
    """

    def __init__(self, lower: Floats, upper: Floats) -> None:
        span = upper - lower
        if not (np.isfinite(span).all() and (span > 0).all()):
            raise ValueError("a range potential needs finite joint limits, lower below upper")
        self._centre = 0.5 * (lower + upper)
        self._angle_per_joint = np.pi / span

    @classmethod
    def build(cls, controller: Controller, body: Body) -> Range:
        """The range potential of a checked controller between its joints' limits."""
        return cls(body.lower, body.upper)

    def evaluate(self, signal: Signal, reference: Floats | None) -> Evaluation:
        """See ``Potential.evaluate``; the reference plays no part."""
        if signal.value.shape != self._centre.shape:
            raise SignalError(
                f"{signal.name} has shape {signal.value.shape}, "
                f"but its limits have shape {self._centre.shape}"
            )
        half_angle = 0.5 * self._angle_per_joint * (signal.value - self._centre)
        slope = np.cos(half_angle) * self._angle_per_joint
        return half_square(-2.0 * np.sin(half_angle), slope[:, None] * signal.jacobian)
