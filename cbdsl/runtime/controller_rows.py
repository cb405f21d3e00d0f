"""The rows of the signal table that a controller reads."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.onset import OnsetForm
from cbdsl.control.plan import Search
from cbdsl.control.rotation import exp
from cbdsl.program.controller import AlongNormals, Controller, Literal, Relative
from cbdsl.sensing.chain import require_executed
from cbdsl.sensing.reading import Reading, flattened, transform
from cbdsl.sensing.signals import Signals
from cbdsl.types.resource import (
    DRAWN,
    EffectorConfiguration,
    FingerForces,
    FingerLoad,
    NetForces,
    NetLoad,
    Resource,
    Source,
    Tip,
    palms_of,
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
    closing = signals.touch.closing[source.hand]
    return Search(seek.once is not None, seek.within, seek.until, joints, closing)


class Anchor(NamedTuple):
    """How a slot keeps its feedback at activation, as of ``plan.SlotForm``."""

    anchor: int = -1
    offset: int = -1
    turned: bool = False
    onset: OnsetForm | None = None

    @property
    def rows(self) -> tuple[int, ...]:
        """Rows that it reads besides the controller's own."""
        return () if self.onset is None or self.onset.tip < 0 else (self.onset.tip,)


def anchor_of(
    controller: Controller, signals: Signals, rows: ControllerRows, period: float
) -> Anchor:
    """How a controller keeps its feedback at activation; without any where it does not.

    Args:
        controller: the controller.
        signals: of the robot.
        rows: of the controller.
        period: of the control ticks, s.
    """
    reference, kind = controller.reference, controller.feedback.type.name
    if not isinstance(reference, Relative) or reference.base is not None:
        return Anchor()
    offset = _constant(Literal(reference.offset), controller.feedback, signals)
    row = signals.bind_written(len(offset))
    signals.table.write(row, Reading(offset, None, 0))
    is_turned, onset = kind in ("orientation", "pose"), controller.onset
    if onset is None:
        return Anchor(rows.declared, row, is_turned)
    assert isinstance(controller.feedback.source, (NetLoad, FingerLoad))
    carrier = signals.touch.carriers.get(controller.feedback.source.hand)
    tip = -1 if carrier is None else signals.bind_tip(Tip(carrier, "position"), -1, (0.0, 0.0, 0.0))
    along = offset / math.hypot(*offset.tolist())
    form = OnsetForm(onset.change, along, onset.window, onset.pace, tip, period)
    return Anchor(rows.declared, row, is_turned, form)


def _bind_feedback(controller: Controller, signals: Signals, reference: int) -> int:
    source = controller.feedback.source
    require_executed(controller.feedback, controller.chains)
    if isinstance(controller.reference, AlongNormals):
        if isinstance(source, FingerForces):
            return signals.bind_normal_forces(source)
        return signals.bind_normal_forces(_palms(source))
    if controller.manipulator is not None:
        assert isinstance(source, EffectorConfiguration)
        return signals.bind_manipulator(source.effector, controller.manipulator, controller.joints)
    if controller.standoff is not None and isinstance(source, Tip):
        return signals.bind_tip(source, reference, controller.standoff)
    return signals.bind(controller.feedback, controller.chains)


def _bind_reference(controller: Controller, signals: Signals) -> int:
    reference = controller.reference
    if reference is None:
        return -1
    if isinstance(reference, Resource):
        if reference.origin in DRAWN:
            return signals.bind_written(reference.type.size)
        return signals.bind(reference)
    if isinstance(reference, Relative):
        offset = _constant(Literal(reference.offset), controller.feedback, signals)
        if reference.base is None:
            return signals.bind_written(len(offset))
        return signals.bind_displaced(reference.base, offset)
    value = _constant(reference, controller.feedback, signals)
    number = signals.bind_written(len(value))
    signals.table.write(number, Reading(value, None, 0))
    return number


def _palms(source: Source) -> NetForces:
    palms = palms_of(source)
    assert palms is not None
    return palms


def _constant(reference: Literal | AlongNormals, feedback: Resource, signals: Signals) -> Floats:
    """A constant reference as a row has it."""
    kind, source = feedback.type.name, feedback.source
    if isinstance(reference, AlongNormals):
        if isinstance(source, FingerForces):
            return reference.force * signals.touch.shares(source.hand)
        return np.full(len(signals.touch.hands(_palms(source).group)), reference.force)
    values = np.array(reference.values)
    if kind == "orientation":
        return exp(values).ravel()
    if kind == "pose":
        return flattened(transform(exp(values[3:]), values[:3]), kind)
    return values
