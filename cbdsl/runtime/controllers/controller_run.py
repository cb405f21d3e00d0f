"""Run of one controller: a view of its slot in the plan."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from cbdsl.control.conditions.predicate import PREDICATES, restart, settings_of
from cbdsl.control.conditions.rate import FORCES, bounds_of
from cbdsl.control.plan import ControllerPlan, SlotForm
from cbdsl.control.potential_registry import build
from cbdsl.control.setting import Setting
from cbdsl.control.signal import SignalError, require_finite
from cbdsl.control.slot import error_bound
from cbdsl.numeric.arrays import Floats, Integers
from cbdsl.program.controller import Controller, Relative
from cbdsl.runtime.controllers.controller_rows import anchor_of, bind_rows
from cbdsl.runtime.controllers.preparation import Preparation
from cbdsl.runtime.controllers.slot_setting import SlotSetting, modified
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.table.reading import Reading
from cbdsl.types.casts import RIGID_HOLD
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.resource import Resource
from cbdsl.types.source_record import chains_of, record_of
from cbdsl.types.state import Predicate

#: Potential of a field below which its displacement leads to its goal directly.
NEAR_GOAL = 1e-2


class Evaluation(NamedTuple):
    """Potential in this tick, in k task coordinates and the n joints of a composition.

    Attributes:
        phi: Value of the potential.
        residual: Error in task coordinates, shape (k,).
        jacobian: Task coordinates per joint, shape (k, n).
    """

    phi: float
    residual: Floats
    jacobian: Floats


class ControllerRun:
    """State of a controller between its activation and its deactivation.

    Attributes:
        controller: Controller that runs.
        own: Indices of the effector's joints among all actuated ones, shape (m,).
        slot: Number of its slot in the plan.
        rows: Compared rows of the signal table.
        needs: All rows that it reads.
        preparation: Preparation before the tick.
        columns: Joint index of each of the n joints of the acting composition, -1 for joints that
            count as fixed, shape (n,).
    """

    columns: Integers

    def __init__(
        self, controller: Controller, signals: Signals, plan: ControllerPlan, period: float
    ) -> None:
        self.controller, self._signals, self._plan = controller, signals, plan
        self._period = period
        own = self.own = signals.joints.pick(controller.joints)
        rows = bind_rows(controller, signals)
        quiescence, limits = controller.quiescence, signals.kinematics
        record = record_of(controller.feedback.source)
        setting = Setting(
            limits.lower[own],
            limits.upper[own],
            len(signals.table.values(rows.feedback)),
            len(signals.table.rows(rows.feedback)),
            signals.sight.cameras() if record.stereo else (),
            limits.circular[own],
        )
        plain = SlotForm(
            build(controller, setting),
            bounds_of(controller, period),
            settings_of(quiescence.rate, quiescence.window, period),
            rows.feedback,
            rows.reference,
            watches=record.compares,
            carried=record.located,
            tolerance=_tolerance(controller),
            share=_share(controller),
            lags=controller.task.name not in FORCES,
        )._replace(**anchor_of(controller, signals, rows)._asdict())
        form = modified(plain, SlotSetting(controller, signals, period))
        self.rows = rows._replace(feedback=form.feedback, reference=form.reference)
        self._potential = form.potential
        self.preparation = Preparation(controller, signals, self.rows, self._potential)
        self.needs = tuple([row for row in (*self.rows, form.carrier) if row >= 0])
        self.slot = plan.add(form)
        # Row of a manually held reference, once there is one.
        self._held = -1
        self._own_reference = self.rows.reference

    def aim(self, row: int) -> None:
        """Let contacts count only at the seen object of a row of the signal table."""
        self._record["object"] = row
        self.needs = tuple(dict.fromkeys((*self.needs, row)))

    def begin(self, rng: np.random.Generator) -> None:
        """Begin an episode with ``rng`` as the source of all samples."""
        self.preparation.begin(rng)
        self.deactivate()

    def deactivate(self) -> None:
        """Forget the activation."""
        self._plan.reset(self.slot)
        self.preparation.forget()

    def activate(self) -> None:
        """Start again if it was idle or at rest on a sample; otherwise go on."""
        predicate = self.predicate
        if predicate == "X" or (self.preparation.samples and predicate == "1"):
            self.deactivate()
            self.predicate = "0"

    def restart_quiescence(self) -> None:
        """Judge rest from the potential's course from now on."""
        restart(self._plan.notes[self.slot])

    def prepare(self) -> None:
        """Prepare the controller before the tick.

        Raises:
            SignalError: If the reference is not finite; the message names it.
        """
        self.preparation.draw()
        if self.preparation.computes:
            self._record["blocked"] = not self.preparation.prepare(self._parameters)
            if self.preparation.moves:
                self.restart_quiescence()

    @property
    def predicate(self) -> str:
        """Predicate X, -, 0 or 1 (Eq 4.1)."""
        predicate: Predicate = PREDICATES[self._plan.predicates.item(self.slot)]
        return predicate

    @predicate.setter
    def predicate(self, predicate: str) -> None:
        self._plan.predicates[self.slot] = PREDICATES.index(Predicate(predicate))

    @property
    def phi(self) -> float:
        """Potential, NaN while undefined."""
        phi: float = self._plan.slots["phi"].item(self.slot)
        return phi

    @property
    def error(self) -> float:
        """Norm of the residual in the unit of the feedback, NaN while undefined."""
        error: float = self._plan.slots["error"].item(self.slot)
        return error

    @property
    def lacks_hold(self) -> bool:
        """True if it is undefined although its signals are not: only a held object changes them."""
        controller = self.controller
        reference = controller.reference
        base = reference.base if isinstance(reference, Relative) else reference
        inputs = [each for each in (controller.feedback, base) if isinstance(each, Resource)]
        return (
            math.isnan(self.error)
            and any(RIGID_HOLD in chain for chain in chains_of(controller.feedback))
            and all(self._signals.read(each) is not None for each in inputs)
        )

    @property
    def seeking(self) -> bool:
        """True if it acts to make its feedback defined."""
        seeking: bool = self._plan.seeking.item(self.slot)
        return seeking

    @property
    def engaged(self) -> bool:
        """True if defined, or seeking again; controllers that require it act meanwhile."""
        return bool(self._record["engaged"])

    @property
    def exhausted(self) -> bool:
        """True if its search ended without success."""
        return bool(self._record["exhausted"])

    @property
    def astray(self) -> bool:
        """True if the fingertips touch something else than the object they seek."""
        return bool(self._record["astray"])

    @property
    def gain(self) -> float:
        """Gain, 1/s."""
        return float(self._record["bounds"][0])

    @gain.setter
    def gain(self, gain: float) -> None:
        changed = replace(self.controller, gain=gain)
        self._record["bounds"][0] = bounds_of(changed, self._period)[0]

    @property
    def largest_gain(self) -> float:
        """Largest gain that takes no residual past 0 within a tick, 1/s."""
        # A Newton step of a spring is half of its residual (Eq 3.18).
        return 2.0 / self._period

    @property
    def can_hold(self) -> bool:
        """True if another position can be held as its reference.

        No preparation may overwrite that position before a tick.
        """
        kind = self.controller.compared.name
        has_reference = self.rows.reference >= 0 and kind == "position"
        is_plain = not self.preparation.is_needed and self.controller.axes is None
        return has_reference and is_plain and len(self.reference) == 3

    @property
    def reference(self) -> Floats:
        """Reference in this tick, in SI, NaN while undefined; empty without one."""
        row = self.rows.reference
        if row < 0:
            return np.zeros(0)
        values = self._signals.table.values(row).copy()
        return values if self._signals.table.is_defined(row) else np.full_like(values, np.nan)

    def hold_reference(self, values: Floats | None) -> None:
        """Compare with a constant from now on; ``None`` restores the program's reference."""
        if values is None:
            row = self._own_reference
        else:
            if self._held < 0:
                self._held = self._signals.bind_written(len(values))
            row = self._held
            self._signals.table.write(row, Reading(values, None, 0))
        self._record["reference"] = row
        self.rows = self.rows._replace(reference=row)

    @property
    def size(self) -> int:
        """Number of task coordinates."""
        return self._potential.size

    @property
    def settled(self) -> bool:
        """True if it is defined, and its error is small enough to count as at rest."""
        return self.error <= self._bound()

    @property
    def arrived(self) -> bool:
        """True if it is at rest within its tolerance."""
        return self.predicate == "1" and self._is_near()

    @property
    def stuck(self) -> bool:
        """True if it is at rest beyond its tolerance."""
        return self.predicate == "1" and not self._is_near()

    def evaluate(self, joints: Integers | None = None) -> Evaluation | None:
        """Return the potential in this tick; ``None`` while undefined.

        Args:
            joints: Indices of n joints, -1 for one that counts as fixed; by default ``columns``.
        """
        if math.isnan(self.phi):
            return None
        columns = self.columns if joints is None else joints
        rows = self._signals.table.rows(self.rows.feedback)
        potential = replace(self._potential, parameters=self._parameters)
        phi, residual, slope = potential.evaluate(*self._values(), len(rows))
        # Index -1 reads the last joint, and the mask replaces that number.
        jacobian = np.where(columns >= 0, rows[:, columns], 0.0)
        return Evaluation(phi, residual, slope @ jacobian)

    def refuse(self) -> SignalError:
        """Return the reason why this tick's numbers cannot be used, naming the resource."""
        name, (value, reference) = self.controller.feedback.name, self._values()
        try:
            require_finite(reference, f"the reference of {name}")
            require_finite(value, f"the value of {name}")
            require_finite(self._signals.table.rows(self.rows.feedback), f"the Jacobian of {name}")
        except SignalError as error:
            return error
        reason = self._potential.refuse
        why = f": {reason(value, reference)}" if reason else ""
        return SignalError(f"the {self.controller.potential} of {name} cannot be computed{why}")

    @property
    def _record(self) -> Any:
        return self._plan.slots[self.slot]

    @property
    def _parameters(self) -> Floats:
        record = self._record
        first = record["parameter"]
        parameters: Floats = self._plan.parameters[first : first + record["parameters"]]
        return parameters

    def _values(self) -> tuple[Floats, Floats]:
        """Return the feedback and its reference as inputs of the potential."""
        table = self._signals.table
        return table.values(self.rows.feedback), (
            table.values(self.rows.reference) if self.rows.reference >= 0 else np.zeros(0)
        )

    def _is_near(self) -> bool:
        """Return whether its error is within the tolerance of an arrival."""
        tolerances = self.controller.arrival
        if not self.settled or tolerances == (math.inf,):
            return self.settled
        # The displacement of a field is bounded: a distant goal is farther away.
        if POTENTIALS[self.controller.potential].field and self.phi > NEAR_GOAL:
            return False
        evaluation = self.evaluate() if len(tolerances) > 1 else None
        if evaluation is None:
            return self.error <= tolerances[0]
        units = self.controller.task.units
        # A free axis shortens the last quantity of a pose.
        of_unit = np.array([units.index(unit) for unit in units])[: self.size]
        parts = [evaluation.residual[of_unit == first] for first in dict.fromkeys(of_unit)]
        return all(np.linalg.norm(p) <= t for p, t in zip(parts, tolerances, strict=True))

    def _bound(self) -> float:
        """Return the largest error at rest, in the unit of the feedback."""
        table = self._signals.table
        return float(error_bound(self._record, table.records, table.value))


def _tolerance(controller: Controller) -> float:
    """Return the largest error at rest that a constant bounds, in the unit of the feedback."""
    quiescence, reference = controller.quiescence, controller.reference
    # At rest, the error is at most the tolerance, and at most a share of the reference's norm.
    bounds = [math.inf if quiescence.tolerance is None else quiescence.tolerance]
    if quiescence.within is not None and isinstance(reference, Relative):
        # The reference follows the feedback; its displacement is constant.
        bounds.append(quiescence.within * math.hypot(*reference.offset))
    return min(bounds)


def _share(controller: Controller) -> float:
    """Return the largest error at rest as a share of the reference's norm."""
    within = controller.quiescence.within
    is_constant = isinstance(controller.reference, Relative)
    return math.inf if within is None or is_constant else within
