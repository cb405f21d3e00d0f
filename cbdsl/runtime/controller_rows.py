"""The rows of the signal table that a controller reads."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.plan import Search
from cbdsl.control.rotation import exp
from cbdsl.program.controller import AlongNormals, Controller, Literal
from cbdsl.sensing.reading import Reading, flattened, transform
from cbdsl.sensing.signals import Signals
from cbdsl.types.resource import (
    EffectorConfiguration,
    FingerForces,
    NetForces,
    Origin,
    Resource,
    Tip,
)

Floats = NDArray[np.float64]


class ControllerRows(NamedTuple):
    """Numbers of rows; -1 for no reference.

    Attributes:
        declared: of the reference as the program has it.
        reference: of the same as modifiers change it.
        feedback: of the feedback.
    """

    declared: int
    reference: int
    feedback: int


def bind_rows(controller: Controller, signals: Signals) -> ControllerRows:
    """Bind the rows of a controller's reference and feedback."""
    declared = reference = _bind_reference(controller, signals)
    if controller.modifiers:
        reference = signals.bind_written(len(signals.table.values(declared)))
    return ControllerRows(declared, reference, _bind_feedback(controller, signals, reference))


def search_of(controller: Controller, signals: Signals) -> Search | None:
    """How a controller acts while its feedback is undefined; ``None`` where it does not."""
    source, seek = controller.feedback.source, controller.seek
    if seek is None:
        return None
    if seek.until is None:
        return Search(seek.once is not None, seek.within, math.nan, ())
    assert isinstance(source, FingerForces)
    joints = signals.touch.flexing[source.hand].tolist()
    return Search(seek.once is not None, seek.within, seek.until, joints)


def _bind_feedback(controller: Controller, signals: Signals, reference: int) -> int:
    source = controller.feedback.source
    if isinstance(controller.reference, AlongNormals):
        assert isinstance(source, (FingerForces, NetForces))
        return signals.bind_normal_forces(source)
    if controller.manipulator is not None:
        assert isinstance(source, EffectorConfiguration)
        return signals.bind_manipulator(source.effector, controller.manipulator, controller.joints)
    if controller.standoff is not None and isinstance(source, Tip):
        return signals.bind_tip(source, reference, controller.standoff)
    return signals.bind(controller.feedback)


def _bind_reference(controller: Controller, signals: Signals) -> int:
    reference = controller.reference
    if reference is None:
        return -1
    if isinstance(reference, Resource):
        if reference.origin is Origin.MODEL:
            return signals.bind_written(reference.type.size)
        return signals.bind(reference)
    value = _constant(reference, controller.feedback, signals)
    number = signals.bind_written(len(value))
    signals.table.write(number, Reading(value, None, 0))
    return number


def _constant(reference: Literal | AlongNormals, feedback: Resource, signals: Signals) -> Floats:
    """A constant reference as a row has it."""
    kind, source = feedback.type.name, feedback.source
    if isinstance(reference, AlongNormals):
        if isinstance(source, FingerForces):
            return reference.force * signals.touch.shares(source.hand)
        assert isinstance(source, NetForces)
        return np.full(len(signals.touch.hands(source.group)), reference.force)
    values = np.array(reference.values)
    if kind == "orientation":
        return exp(values).ravel()
    if kind == "pose":
        return flattened(transform(exp(values[3:]), values[:3]), kind)
    return values
