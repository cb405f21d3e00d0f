"""Implementations of the potentials, by the names that programs use."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

import numpy as np

from cbdsl.control.potential import (
    Potential,
    PotentialError,
    address_of,
    defined_potentials,
    interpreted,
)
from cbdsl.control.setting import Setting
from cbdsl.program.controller import Controller
from cbdsl.types.potential import POTENTIALS

Builder = Callable[[Controller, Setting], Potential]
"""Function that builds the potential of a controller."""


def build(controller: Controller, setting: Setting) -> Potential:
    """Return the potential of a checked controller.

    Args:
        controller: Controller with the name of the potential and the type of its feedback.
        setting: Constants of the robot, for ``controller.joints``.

    Raises:
        ValueError: If the robot lacks a requirement of the potential, such as joint limits or
            cameras.
        PluginError: If another package's potential breaks its contract; the message names both.
    """
    name = controller.potential
    module, function = POTENTIALS[name].implementation.split(":")
    if POTENTIALS.registry.is_builtin(name):
        builder: Builder = getattr(import_module(module), function)
        return builder(controller, setting)
    # Every failure here is an error of the package.
    try:
        potential: Potential = getattr(import_module(module), function)(controller, setting)
        _try_out(potential, setting)
    except Exception as error:
        reason = f"{type(error).__name__}: {error}"
        raise POTENTIALS.registry.fault(name, reason) from error
    return potential


def compile_potentials() -> None:
    """Compile the potentials of cbdsl, including unused ones."""
    for name in POTENTIALS.registry.builtins:
        import_module(POTENTIALS[name].implementation.split(":")[0])
    own = __name__.partition(".")[0]
    for function in defined_potentials():
        if function.__module__.partition(".")[0] == own:
            address_of(function)


def _try_out(potential: Potential, setting: Setting) -> None:
    """Evaluate a potential in Python, where indices beyond its arrays are errors.

    In machine code, such an index would overwrite memory.

    Raises:
        PotentialError: If it is not a potential, or does not compute a number.
    """
    if not isinstance(potential, Potential):
        raise PotentialError(f"its builder returns a {type(potential).__name__}, not a Potential")
    address_of(potential.function)
    value, rows = np.full(setting.components, 0.1), setting.rows
    if potential.identity and potential.size != rows:
        raise PotentialError(
            f"its slope cannot be the identity of {potential.size} and {rows} rows"
        )
    slope = np.zeros((0 if potential.identity else potential.size, rows))
    residual = np.zeros(potential.size)
    function = interpreted(potential.function)
    function(value, np.full_like(value, 0.2), potential.parameters, residual, slope)
