"""The quadratic potential (Section 3.1.1, Eq 3.1)."""

from __future__ import annotations

import numpy as np

from cbdsl.control.body import Body
from cbdsl.control.potential import Evaluation, half_square
from cbdsl.control.rotation import align, log
from cbdsl.control.signal import Floats, Signal, SignalError, require_finite
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
        self._free_axis = None if free_axis is None else "xyz".index(free_axis)
        self._matrix = {ORIENTATION.name: (3, 3), POSE.name: (4, 4)}.get(kind.name)

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
        for what, value in ((signal.name, signal.value), ("its reference", reference)):
            if value.shape != shape:
                raise SignalError(
                    f"the {self._kind} {signal.name} needs values of shape {shape}, "
                    f"but {what} has shape {value.shape}"
                )
        require_finite(reference, f"the reference of {signal.name}")
        return half_square(*self._difference(signal, reference))

    def _difference(self, signal: Signal, reference: Floats) -> Coordinates:
        value, jacobian = signal.value, signal.jacobian
        if self._kind.name == ORIENTATION.name:
            return self._turn(value, reference, jacobian)
        if self._kind.name == POSE.name:
            turn, rows = self._turn(value[:3, :3], reference[:3, :3], jacobian[3:])
            shift = reference[:3, 3] - value[:3, 3]
            return np.concatenate((shift, turn)), np.vstack((jacobian[:3], rows))
        return reference - value, jacobian

    def _turn(self, rotation: Floats, wanted: Floats, jacobian: Floats) -> Coordinates:
        """Residual and Jacobian of an orientation; ``jacobian`` is angular, (3, n)."""
        if self._free_axis is None:
            return log(wanted @ rotation.T), jacobian
        axis = self._free_axis
        others = rotation.T[[(axis + 1) % 3, (axis + 2) % 3]]  # (2, 3), world to tip
        turn = align(rotation[:, axis], wanted[:, axis], fallback=others[0])
        return others @ turn, others @ jacobian
