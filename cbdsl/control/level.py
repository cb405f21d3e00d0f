"""One controller's part in the law in one tick."""

from __future__ import annotations

from typing import NamedTuple

from cbdsl.control.signal import Floats


class Level(NamedTuple):
    """Displacement that one controller wants in this tick, and its Jacobian.

    Attributes:
        name: the controller, for messages and explanations.
        jacobian: task coordinates per joint, shape (k, n).
        velocity: wanted displacement of the task coordinates in this tick, gain and bounds
            applied, shape (k,).
    """

    name: str
    jacobian: Floats
    velocity: Floats
