"""The implementations of the potentials, by the names that programs use."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from cbdsl.control.potential import Potential
from cbdsl.control.setting import Setting
from cbdsl.program.controller import Controller
from cbdsl.types.potential import POTENTIALS

Builder = Callable[[Controller, Setting], Potential]
"""Makes the potential of a controller."""


def build(controller: Controller, setting: Setting) -> Potential:
    """The potential of a checked controller.

    Args:
        controller: names the potential and the type of its feedback.
        setting: constants of the robot, of ``controller.joints``.

    Raises:
        ValueError: the robot lacks what the potential needs, such as joint limits or cameras.
    """
    module, function = POTENTIALS[controller.potential].implementation.split(":")
    builder: Builder = getattr(import_module(module), function)
    return builder(controller, setting)
