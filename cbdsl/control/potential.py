"""Artificial potentials: compiled functions of a value and its reference (Omega_phi, Eq 3.7).

A potential is independent of joints and gains. It is computed from the value of one row of the
signal table and that of its reference, in k task coordinates. The control law moves the joints by
the row's Jacobian. The tick calls potentials by their native addresses. Potentials of other
packages therefore cause no recompilation and no slowdown.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cache
from types import FunctionType
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.dispatcher import Dispatcher
from numba.core.errors import NumbaError
from numba.experimental.function_type import _get_jit_address
from numba.extending import intrinsic
from numpy.typing import NDArray

from cbdsl.kinematics.obstacle import Obstacle
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import Function, compiled_once

_VECTOR, _MATRIX = types.float64[::1], types.float64[:, ::1]

#: phi = f(value, reference, parameters, residual, slope).
SIGNATURE = types.float64(_VECTOR, _VECTOR, _VECTOR, _VECTOR, _MATRIX)


_defined: list[Callable[..., float]] = []


class PotentialError(ValueError):
    """Function that is not a valid potential; the message says why."""


class Rule(IntEnum):
    """Rule that turns a potential into a displacement of its task coordinates, for a gain of 1.

    Attributes:
        RESIDUAL: Half the square of a residual; half of the residual is the Newton step (Eq 3.18).
        TO_ZERO: Potential with itself as one coordinate and a minimum of 0; Newton step towards 0.
        DESCENT: Potential with unknown minimum; the joints move by the negative gradient.
    """

    RESIDUAL = 0
    TO_ZERO = 1
    DESCENT = 2


def potential(function: Function) -> Function:
    """Return a compiled potential ``(value, reference, parameters, residual, slope) -> phi``.

    Args of the function:
        value: Value of the feedback, shape (m,); a rotation row by row, shape (9,); a pose's
            position before its rotation, shape (12,).
        reference: Value of the reference, shaped like the value, or empty.
        parameters: Parameters of the controller, shape (p,).
        residual: Becomes the error in task coordinates, shape (k,).
        slope: Zeros; becomes the derivative of minus the residual, or of phi without a residual, by
            the rows of the feedback's Jacobian, shape (k, rows); untouched if it is the identity.

    Returns:
        Value of phi; NaN if it cannot be computed.
    """
    kernel = compiled_once(function)
    _defined.append(kernel)
    return kernel


def defined_potentials() -> Sequence[Callable[..., float]]:
    """Return the potentials of all modules that were imported."""
    return tuple(_defined)


def address_of(function: Callable[..., float]) -> int:
    """Return the native address of a potential.

    Raises:
        PotentialError: If it is not compiled, or not for these arguments and a float.
    """
    name = getattr(function, "__name__", str(function))
    compile_for = getattr(function, "compile", None)
    if compile_for is None:
        raise PotentialError(f"potential '{name}' is not compiled: decorate it with @potential")
    try:
        compile_for(SIGNATURE.args)
    except (NumbaError, TypeError, RuntimeError) as error:
        first = str(error).strip().splitlines()[0]
        raise PotentialError(f"potential '{name}' cannot be compiled: {first}") from None
    returned = function.overloads[SIGNATURE.args].signature.return_type  # type: ignore[attr-defined]
    if returned != types.float64:
        kind = types.unliteral(returned)
        raise PotentialError(f"potential '{name}' returns {kind}, not a float")
    address: int = _get_jit_address(function, SIGNATURE)
    return address


@cache
def interpreted(function: Any) -> Callable[..., Any]:
    """Return a compiled function and all its callees in the form of Python functions.

    In Python, indices beyond an array are errors. Functions that are called from compiled code only
    have no entry point from Python.
    """
    source = getattr(function, "py_func", function)
    scope = dict(source.__globals__)
    for name in source.__code__.co_names:
        if isinstance(scope.get(name), Dispatcher):
            scope[name] = interpreted(scope[name])
    return FunctionType(source.__code__, scope, source.__name__, None, source.__closure__)


@intrinsic(prefer_literal=False)
def call_at(
    typing_context: Any,
    address: Any,
    value: Any,
    reference: Any,
    parameters: Any,
    residual: Any,
    slope: Any,
) -> Any:
    """Call the potential at an address, from compiled code."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Sequence[Any]) -> Any:
        convention = context.call_conv
        kind = convention.get_function_type(SIGNATURE.return_type, SIGNATURE.args)
        pointer = builder.inttoptr(arguments[0], ir.PointerType(kind))
        status, phi = convention.call_function(
            builder, pointer, SIGNATURE.return_type, SIGNATURE.args, arguments[1:]
        )
        with cgutils.if_unlikely(builder, status.is_error):
            convention.return_status_propagate(builder, status)
        return phi

    return types.float64(types.int64, *SIGNATURE.args), generate


Prepare = Callable[[Floats, Floats, Sequence[Obstacle], Floats], bool | None]
"""Function that writes parameters from value, reference and obstacles before the tick.

It returns True if the controller is not at rest, although its potential may stay the same.
"""


@dataclass(frozen=True)
class Potential:
    """Potential of one controller.

    Attributes:
        function: Function in the form that ``potential`` describes.
        size: Number k of its task coordinates.
        rule: Rule that turns it into a displacement.
        parameters: Parameters of the controller, shape (p,).
        identity: True if its slope is the identity, which it then does not write.
        side: 1 for upper bounds, -1 for lower ones, otherwise 0. A bound writes the slopes of all
            components, of which each selects or weighs components of the value. Its residual is 0
            where slope times (reference - value) has the sign of the side.
        prepare: Computation before the tick, or ``None``.
        refuse: Function that explains a NaN from a value and a reference.
    """

    function: Callable[..., float]
    size: int
    rule: Rule = Rule.RESIDUAL
    parameters: Floats = field(default_factory=lambda: np.zeros(0))
    identity: bool = False
    side: float = 0.0
    prepare: Prepare | None = None
    refuse: Callable[[Floats, Floats], str] | None = None

    def evaluate(
        self, value: Floats, reference: Floats, rows: int
    ) -> tuple[float, Floats, NDArray[np.float64]]:
        """Return phi, the residual (k,) and the slope (k, rows), as computed in the tick.

        Components that obey a bound have a slope of 0.
        """
        residual, slope = np.zeros(self.size), np.zeros((self.size, rows))
        phi = self.function(value, reference, self.parameters, residual, slope)
        if self.identity:
            slope[:] = np.eye(self.size)
        if self.side:
            slope[residual == 0.0] = 0.0
        return phi, residual, slope
