"""A measured quantity and how the joints move it: what potentials are computed from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.obstacle import Obstacle
from cbdsl.numeric.compiled import compiled_once

Floats = NDArray[np.float64]


class SignalError(ValueError):
    """A number that control would act on is missing, misshapen or not finite; says which."""


def require_finite(values: Floats, what: str) -> None:
    """Refuse NaN and infinity before they reach a motor.

    Raises:
        SignalError: some of ``values`` is not finite; the message begins with ``what``.
    """
    if not is_finite(values):
        raise SignalError(f"{what} is not finite: {values.tolist()}")


@compiled_once
def is_finite(values: Floats) -> bool:
    """Whether all numbers are finite."""
    total = 0.0
    for value in values.flat:
        total += 0.0 * value
    return total == 0.0


@compiled_once
def _are_finite(value: Floats, jacobian: Floats) -> bool:
    total = 0.0
    for component in value.flat:
        total += 0.0 * component
    for component in jacobian.flat:
        total += 0.0 * component
    return total == 0.0


@dataclass(slots=True)
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
        if not _are_finite(self.value, self.jacobian):
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
        if not is_finite(curvature):
            require_finite(curvature, f"the curvature of {self.name}")
        rows, joints = self.jacobian.shape
        if curvature.shape != (rows, joints, joints):
            raise SignalError(
                f"the curvature of {self.name} has shape {curvature.shape}, "
                f"but its Jacobian has shape {self.jacobian.shape}"
            )
