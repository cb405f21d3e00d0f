"""Rows of the signal table that a controller reads."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cbdsl.kinematics.rotation import exp
from cbdsl.numeric.arrays import Floats
from cbdsl.program.controller import AlongNormals, Controller, Literal, Relative
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.table.chain import require_executed
from cbdsl.sensing.table.reading import Reading, flattened, transform
from cbdsl.types.modifier import MODIFIERS
from cbdsl.types.resource import Resource
from cbdsl.types.source_record import Normals, configured, normals_of, owner_of


class ControllerRows(NamedTuple):
    """Numbers of a controller's rows; -1 for no reference.

    Attributes:
        declared: Row of the reference as the program declares it.
        reference: Row of the reference as modifiers change it.
        feedback: Row of the feedback.
    """

    declared: int
    reference: int
    feedback: int


def bind_rows(controller: Controller, signals: Signals) -> ControllerRows:
    """Bind the rows of a controller's reference and feedback."""
    declared = reference = _bind_reference(controller, signals)
    if any(MODIFIERS.get(each.name).implementation for each in controller.modifiers):
        # Modifiers in Python write their result to a row of their own, so that the declared one
        # stays unchanged.
        reference = signals.bind_written(len(signals.table.values(declared)))
    return ControllerRows(declared, reference, _bind_feedback(controller, signals))


class Anchor(NamedTuple):
    """Storage of the feedback at activation, as in ``plan.SlotForm``."""

    anchor: int = -1
    offset: int = -1
    turned: bool = False


def anchor_of(controller: Controller, signals: Signals, rows: ControllerRows) -> Anchor:
    """Return how a controller stores its feedback at activation; empty if it does not."""
    reference, kind = controller.reference, controller.feedback.type.name
    # Only a displacement without a base refers to the feedback at activation.
    if not isinstance(reference, Relative) or reference.base is not None:
        return Anchor()
    offset = _constant(Literal(reference.offset), controller, signals)
    row = signals.bind_written(len(offset))
    signals.table.write(row, Reading(offset, None, 0))
    return Anchor(rows.declared, row, kind in ("orientation", "pose"))


def _bind_feedback(controller: Controller, signals: Signals) -> int:
    source = controller.feedback.source
    require_executed(controller.feedback, controller.chains)
    if isinstance(controller.reference, AlongNormals):
        return signals.bind_normal_forces(source)
    if controller.manipulator is not None:
        return signals.kinematic_rows.manipulator(
            configured(source), controller.manipulator, controller.joints
        )
    return signals.bind(controller.feedback, controller.chains)


def _bind_reference(controller: Controller, signals: Signals) -> int:
    reference = controller.reference
    if reference is None:
        return -1
    if isinstance(reference, Resource):
        if reference.is_drawn:
            return signals.bind_written(reference.type.size)
        return signals.bind(reference)
    if isinstance(reference, Relative):
        offset = _constant(Literal(reference.offset), controller, signals)
        if reference.base is None:
            return signals.bind_written(len(offset))
        return signals.bind_displaced(reference.base, offset)
    value = _constant(reference, controller, signals)
    number = signals.bind_written(len(value))
    signals.table.write(number, Reading(value, None, 0))
    return number


def _constant(
    reference: Literal | AlongNormals, controller: Controller, signals: Signals
) -> Floats:
    """Return a constant reference in the form of a row."""
    kind, feedback = controller.compared.name, controller.feedback
    if isinstance(reference, AlongNormals):
        owner = owner_of(feedback.source)
        if normals_of(feedback) is Normals.FINGERS:
            return reference.force * signals.touch.shares(owner)
        return np.full(len(signals.touch.hands(owner)), reference.force)
    values = np.array(reference.values)
    # Programs write an orientation as a rotation vector, rad, and rows hold rotation matrices. A
    # pose begins with its position.
    if kind == "orientation":
        return exp(values).ravel()
    if kind == "pose":
        return flattened(transform(exp(values[3:]), values[:3]), kind)
    return values
