"""What every artificial potential gives to the control law."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from cbdsl.control.signal import Floats, Signal
from cbdsl.numeric.compiled import compiled_once


class Evaluation(NamedTuple):
    """A potential at one posture, in k task coordinates and n joints.

    The gradient of phi by the joints is ``-jacobian.T @ residual`` wherever phi is half the
    residual's square, which keeps the rows, and with them the priority, at the goal where the
    gradient itself vanishes. The one task coordinate of any other potential is phi itself, and
    its Jacobian is the gradient.

    Attributes:
        phi: the potential.
        residual: error in task coordinates; moving the task by it brings phi to 0 where that is
            its minimum, shape (k,).
        jacobian: task coordinates per joint, shape (k, n).
        step: displacement of the task coordinates for a gain of 1, shape (k,): the Newton step
            towards phi = 0 (Eq 3.18) where the minimum is known to be 0, else along the gradient.
    """

    phi: float
    residual: Floats
    jacobian: Floats
    step: Floats


#: The potentials that are compiled.
SPRING, RANGE, MANIPULABILITY, ALIGNMENT = 0, 1, 2, 3


class Compiled(NamedTuple):
    """How a potential is computed in one compiled call with all else that a controller does.

    Attributes:
        kind: ``SPRING``, ``RANGE``, ``MANIPULABILITY``, or ``ALIGNMENT`` for the spring of an
            orientation that may turn about an axis.
        constants: what it needs beside the signal, shape (r, m).
    """

    kind: int
    constants: Floats


class Potential(Protocol):
    """One controller's artificial potential (Omega_phi, Eq 3.7).

    Attributes:
        size: number of its task coordinates, k.
        compiled: the same as ``evaluate``, for speed; ``None`` for what is only evaluated.
    """

    @property
    def size(self) -> int: ...

    @property
    def compiled(self) -> Compiled | None: ...

    def evaluate(self, signal: Signal, reference: Floats | None) -> Evaluation:
        """Compute phi and how to lower it.

        Args:
            signal: the feedback.
            reference: what the feedback shall become, shaped like its value; ``None`` for
                potentials that compare with nothing.

        Raises:
            SignalError: the signal or the reference cannot be used; the message names it.
        """
        ...


def half_square(residual: Floats, jacobian: Floats) -> Evaluation:
    """The evaluation of phi = residual . residual / 2, whose Newton step is half the residual."""
    half = 0.5 * residual
    return Evaluation(float(residual.dot(half)), residual, jacobian, half)


def newton(phi: float, gradient: Floats) -> Evaluation:
    """The evaluation of a phi without residual whose minimum is 0, by its gradient, shape (n,)."""
    towards_zero = np.array([-phi])
    return Evaluation(phi, towards_zero, gradient[None], towards_zero)


def gradient_descent(phi: float, gradient: Floats) -> Evaluation:
    """The evaluation of a phi of unknown minimum, by its gradient, shape (n,).

    Newton's step would lead to phi = 0, wherever the minimum is. This one makes the shortest
    displacement of the joints equal to the negative gradient.
    """
    row, downhill = _downhill(gradient)
    return Evaluation(phi, downhill, row, downhill)


@compiled_once
def _downhill(gradient: Floats) -> tuple[Floats, Floats]:
    """A gradient (n,) as a row (1, n), and minus its square, shape (1,)."""
    row, downhill = np.empty((1, len(gradient))), np.zeros(1)
    for joint in range(len(gradient)):
        row[0, joint] = gradient[joint]
        downhill[0] -= gradient[joint] * gradient[joint]
    return row, downhill
