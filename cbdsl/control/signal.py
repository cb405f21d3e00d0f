"""A measured quantity and how the joints move it: what potentials are computed from."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.obstacle import Obstacle

Floats = NDArray[np.float64]


class SignalError(ValueError):
    """A number that control would act on is missing, misshapen or not finite; says which."""


def require_finite(values: Floats, what: str) -> None:
    """Refuse NaN and infinity before they reach a motor.

    Raises:
        SignalError: some of ``values`` is not finite; the message begins with ``what``.
    """
    # A sum of squares is finite only where all numbers are; squares may be infinite all the same.
    if not math.isfinite(np.vdot(values, values)) and not np.isfinite(values).all():
        raise SignalError(f"{what} is not finite: {values.tolist()}")


@dataclass(frozen=True)
class Signal:
    """The value of a resource in one tick, and its sensitivity to the composition's n joints.

    Attributes:
        name: the resource, for messages.
        value: in the resource's SI unit, shape (m,); a rotation matrix (3, 3) for an
            orientation and a homogeneous transform (4, 4) for a pose, from tip to world.
        jacobian: shape (m, n); for an orientation the angular velocity in the world frame per
            joint velocity, (3, n); for a pose linear above angular velocity, (6, n).
        curvature: derivative of the Jacobian by the joints, shape (m, n, n), where the potential
            needs it: ``curvature[:, i, j]`` is that of ``jacobian[:, i]`` by joint j.
        obstacles: what the value has to keep away from, in its unit.

    Raises:
        SignalError: the value or the Jacobian is not finite, or the Jacobian is no matrix.
    """

    name: str
    value: Floats
    jacobian: Floats
    curvature: Floats | None = None
    obstacles: tuple[Obstacle, ...] = ()

    def __post_init__(self) -> None:
        require_finite(self.value, f"the value of {self.name}")
        require_finite(self.jacobian, f"the Jacobian of {self.name}")
        if self.jacobian.ndim != 2:
            raise SignalError(f"the Jacobian of {self.name} has shape {self.jacobian.shape}")
        if self.curvature is not None:
            self._check_curvature(self.curvature)
        for obstacle in self.obstacles:
            corners = np.concatenate((obstacle.lower, obstacle.upper, [obstacle.radius]))
            require_finite(corners, f"the obstacle {obstacle.name}")

    def _check_curvature(self, curvature: Floats) -> None:
        require_finite(curvature, f"the curvature of {self.name}")
        rows, joints = self.jacobian.shape
        if curvature.shape != (rows, joints, joints):
            raise SignalError(
                f"the curvature of {self.name} has shape {curvature.shape}, "
                f"but its Jacobian has shape {self.jacobian.shape}"
            )
