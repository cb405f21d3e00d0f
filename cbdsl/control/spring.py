"""The quadratic potential (Section 3.1.1, Eq 3.1)."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from cbdsl.control.body import Body
from cbdsl.control.potential import ALIGNMENT, SPRING, Compiled, Evaluation, half_square
from cbdsl.control.rotation import align, log
from cbdsl.control.signal import Floats, Signal, SignalError, require_finite
from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.program.controller import AlongNormals, Controller
from cbdsl.types.resource_type import ORIENTATION, POSE, ResourceType

Coordinates = tuple[Floats, Floats]
"""Residual (k,) and Jacobian (k, n)."""


class Spring:
    """phi = e . e / 2 with e the difference between reference and feedback in the feedback's type.

    Configurations, positions, headings, forces, torques and wrenches subtract. Orientations
    differ by a rotation vector in the world frame; poses by translation above rotation.

    Args:
        kind: the type of the feedback.
        free_axis: axis of the tip, ``x``, ``y`` or ``z``, that is aligned with the reference's
            while the tip may turn about it: two residuals, in the tip's two other axes.
        along_normals: whether one component per factor is compared, that along its normal.
    """

    def __init__(
        self, kind: ResourceType, free_axis: str | None = None, along_normals: bool = False
    ) -> None:
        self._kind = kind
        # A free axis takes one coordinate from an orientation.
        self.size = (kind.factors if along_normals else kind.size) - (free_axis is not None)
        self._free_axis = None if free_axis is None else "xyz".index(free_axis)
        self._matrix: tuple[int, int] | None
        self._difference: Callable[[Signal, Floats], Coordinates] | None
        self._matrix, self._difference = {
            ORIENTATION.name: ((3, 3), self._turned),
            POSE.name: ((4, 4), self._moved),
        }.get(kind.name, (None, None))
        self.compiled: Compiled | None = None
        if self._difference is None:
            self.compiled = Compiled(SPRING, np.zeros((0, 0)))
        elif kind == ORIENTATION and self._free_axis is not None:
            self.compiled = Compiled(ALIGNMENT, np.array([[float(self._free_axis)]]))

    @classmethod
    def build(cls, controller: Controller, body: Body) -> Spring:
        """The spring of a checked controller; the body does not matter to it."""
        along_normals = isinstance(controller.reference, AlongNormals)
        return cls(controller.feedback.type, controller.free_axis, along_normals)

    def evaluate(self, signal: Signal, reference: Floats | None) -> Evaluation:
        """See ``Potential.evaluate``."""
        if reference is None:
            raise SignalError(f"a spring needs a reference to compare {signal.name} with")
        shape = self._matrix or (len(signal.jacobian),)
        if signal.value.shape != shape or reference.shape != shape:
            self._refuse(signal, reference, shape)
        if self._difference is None:
            found = half_square(reference - signal.value, signal.jacobian)
        else:
            require_finite(reference, f"the reference of {signal.name}")
            found = half_square(*self._difference(signal, reference))
        if not math.isfinite(found.phi):
            require_finite(reference, f"the reference of {signal.name}")
        return found

    def _refuse(self, signal: Signal, reference: Floats, shape: tuple[int, ...]) -> None:
        bad = signal.value.shape != shape
        what, value = (signal.name, signal.value) if bad else ("its reference", reference)
        raise SignalError(
            f"the {self._kind} {signal.name} needs values of shape {shape}, "
            f"but {what} has shape {value.shape}"
        )

    def _turned(self, signal: Signal, reference: Floats) -> Coordinates:
        return self._turn(signal.value, reference, signal.jacobian)

    def _moved(self, signal: Signal, reference: Floats) -> Coordinates:
        value, jacobian = signal.value, signal.jacobian
        turn, rows = self._turn(value[:3, :3], reference[:3, :3], jacobian[3:])
        shift = reference[:3, 3] - value[:3, 3]
        return np.concatenate((shift, turn)), np.vstack((jacobian[:3], rows))

    def _turn(self, rotation: Floats, wanted: Floats, jacobian: Floats) -> Coordinates:
        """Residual and Jacobian of an orientation; ``jacobian`` is angular, (3, n)."""
        if self._free_axis is None:
            return log(wanted @ rotation.T), jacobian
        residual, others = np.empty(2), np.empty((2, 3))
        aim(rotation.ravel(), wanted.ravel(), self._free_axis, residual, others)
        return residual, others @ jacobian


@compiled
def subtract(value: Floats, reference: Floats, residual: Floats) -> float:
    """phi of values that subtract, shape (k,), and their residual; NaN if shapes differ."""
    if not len(value) == len(reference) == len(residual):
        return math.nan
    phi = 0.0
    for i in range(len(value)):
        residual[i] = reference[i] - value[i]
        phi += 0.5 * residual[i] * residual[i]
    return phi


@compiled_once
def aim(rotation: Floats, wanted: Floats, axis: int, residual: Floats, others: Floats) -> float:
    """phi of a tip that may turn about one of its axes.

    Args:
        rotation: of the tip, row by row, shape (9,).
        wanted: the reference, row by row, shape (9,).
        axis: index of the axis.
        residual: takes the residual, in the tip's two other axes, rad, shape (2,).
        others: takes these axes in the world frame, shape (2, 3).
    """
    for i in range(2):
        others[i] = rotation[(axis + 1 + i) % 3 :: 3]
    turn = align(rotation[axis::3], wanted[axis::3], others[0])
    for i in range(2):
        residual[i] = others[i, 0] * turn[0] + others[i, 1] * turn[1] + others[i, 2] * turn[2]
    phi: float = 0.5 * (residual[0] * residual[0] + residual[1] * residual[1])
    return phi
