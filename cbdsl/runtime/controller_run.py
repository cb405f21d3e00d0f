"""One controller while it runs: a view of its slot in the plan."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.field import NoPathError
from cbdsl.control.obstacle import Obstacle
from cbdsl.control.plan import ControllerPlan, Search, SlotForm
from cbdsl.control.predicate import PREDICATE, PREDICATES, restart, settings_of
from cbdsl.control.rate import bounds_of
from cbdsl.control.registry import build
from cbdsl.control.rotation import exp
from cbdsl.control.setting import Setting
from cbdsl.control.signal import SignalError, require_finite
from cbdsl.control.tick import reset_slot
from cbdsl.program.controller import AlongNormals, Ball, Controller, Field, Literal, Modifier, Seek
from cbdsl.sensing.density import Sampler
from cbdsl.sensing.reading import Reading, flattened, transform
from cbdsl.sensing.signals import Signals
from cbdsl.types.modifier import MODIFIERS
from cbdsl.types.resource import (
    EffectorConfiguration,
    FingerForces,
    Headings,
    NetForces,
    Origin,
    Resource,
    Tip,
)
from cbdsl.types.state import Predicate

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_NO_FUNNEL = (0.0, 0.0, 0.0)


class Evaluation(NamedTuple):
    """A potential in this tick, in k task coordinates and the n joints of a composition.

    Attributes:
        phi: the potential.
        residual: error in task coordinates, shape (k,).
        jacobian: task coordinates per joint, shape (k, n).
    """

    phi: float
    residual: Floats
    jacobian: Floats


def modifier_of(modifier: Modifier) -> Callable[..., Floats]:
    """The function that changes a reference.

    Raises:
        PluginError: its package does not have it.
    """
    module, function = MODIFIERS.get(modifier.name).implementation.split(":")
    try:
        change: Callable[..., Floats] = getattr(import_module(module), function)
    except Exception as error:
        raise MODIFIERS.fault(modifier.name, f"{type(error).__name__}: {error}") from error
    return change


class ControllerRun:
    """A controller's state between its activation and its deactivation.

    Attributes:
        controller: what runs.
        own: indices of the effector's joints among all actuated ones, shape (m,).
        slot: its number in the plan.
        feedback, reference: numbers of rows of the signal table; -1 for no reference.
        columns: which joint each of the n of the composition that it acts in is, -1 for those that
            count as still, shape (n,).
        samples: whether its reference is drawn from an internal model.
        no_path: why no free path leads to the reference; empty where one does.
    """

    columns: Integers

    def __init__(
        self, controller: Controller, signals: Signals, plan: ControllerPlan, period: float
    ) -> None:
        self.controller, self._signals, self._plan = controller, signals, plan
        reference = controller.reference
        self.samples = isinstance(reference, Resource) and reference.origin is Origin.MODEL
        own = self.own = signals.joints.pick(controller.joints)
        self._unmodified = self._bind_reference()
        self._modify = [(each, modifier_of(each)) for each in controller.modifiers]
        self.reference = (
            signals.bind_written(len(signals.table.values(self._unmodified)))
            if self._modify
            else self._unmodified
        )
        self.feedback = self._bind_feedback()
        quiescence, limits = controller.quiescence, signals.kinematics
        is_seen_twice = isinstance(controller.feedback.source, Headings)
        self._potential = build(
            controller,
            Setting(
                limits.lower[own],
                limits.upper[own],
                len(signals.table.values(self.feedback)),
                len(signals.table.rows(self.feedback)),
                signals.sight.cameras() if is_seen_twice else (),
            ),
        )
        self._tolerance = math.inf if quiescence.tolerance is None else quiescence.tolerance
        self.slot = plan.add(
            SlotForm(
                self._potential,
                bounds_of(controller, period),
                settings_of(quiescence.rate, quiescence.window, period),
                self.feedback,
                self.reference,
                controller.funnel or _NO_FUNNEL,
                None if controller.seek is None else self._search(controller.seek),
                controller.requires is not None,
            )
        )

    def begin(self, rng: np.random.Generator) -> None:
        """Begin an episode, in which ``rng`` is for all that is drawn."""
        self._rng = rng
        self._sampler: Sampler | None = None
        self.deactivate()

    def deactivate(self) -> None:
        """Forget the activation."""
        reset_slot(self._plan.slots, self.slot, self._plan.before)
        self.no_path = ""
        if self.samples:
            self._signals.table.forget(self._unmodified)

    def activate(self) -> None:
        """Start anew where it was idle or at rest on a sample; otherwise go on."""
        predicate = self.predicate
        if predicate == "X" or (self.samples and predicate == "1"):
            self.deactivate()
            self.predicate = "0"

    def restart_quiescence(self) -> None:
        """Judge rest by what the potential does from now on."""
        restart(self._record["notes"])

    def prepare(self) -> None:
        """Draw a sample or solve for a field, where this controller needs one, before the tick.

        Raises:
            SignalError: the reference is not finite; the message names it.
        """
        if self.samples and not self._signals.table.is_defined(self._unmodified):
            self._draw()
        if self._modify:
            self._change_reference()
        if self._potential.prepare is None:
            return
        self._record["blocked"] = False
        if self._signals.table.is_defined(self.feedback) and self._signals.table.is_defined(
            self.reference
        ):
            self._solve()

    @property
    def needs_preparation(self) -> bool:
        """Whether there is anything to draw or to solve for."""
        return self.samples or bool(self._modify) or self._potential.prepare is not None

    @property
    def rows(self) -> tuple[int, ...]:
        """Numbers of the rows that it reads, the reference first."""
        return tuple(row for row in (self._unmodified, self.reference, self.feedback) if row >= 0)

    @property
    def predicate(self) -> str:
        """X - 0 1 (Eq 4.1)."""
        predicate: Predicate = PREDICATES[self._plan.slots["notes"].item(self.slot, PREDICATE)]
        return predicate

    @predicate.setter
    def predicate(self, predicate: str) -> None:
        self._record["notes"][PREDICATE] = PREDICATES.index(Predicate(predicate))

    @property
    def phi(self) -> float:
        """The potential, NaN while undefined."""
        phi: float = self._plan.slots["phi"].item(self.slot)
        return phi

    @property
    def error(self) -> float:
        """Norm of the residual in the unit of the feedback, NaN while undefined."""
        error: float = self._plan.slots["error"].item(self.slot)
        return error

    @property
    def seeking(self) -> bool:
        """Whether it acts to make its feedback defined."""
        seeking: bool = self._plan.slots["seeking"].item(self.slot)
        return seeking

    @property
    def exhausted(self) -> bool:
        """Whether it has sought in vain."""
        return bool(self._record["exhausted"])

    @property
    def size(self) -> int:
        """Number of task coordinates."""
        return self._potential.size

    @property
    def settled(self) -> bool:
        """Whether it is defined and its error small enough to earn a reward."""
        return self.error <= self._bound()

    def evaluate(self) -> Evaluation | None:
        """The potential in this tick, in the joints that act; ``None`` while undefined."""
        if math.isnan(self.phi):
            return None
        record, table = self._record, self._signals.table
        rows = table.rows(self.feedback)
        residual, slope = np.zeros(self.size), np.zeros((self.size, len(rows)))
        phi = self._potential.function(*self._values(), self._parameters, residual, slope)
        if record["identity"]:
            slope = np.eye(self.size)
        jacobian = np.where(self.columns >= 0, rows[:, self.columns], 0.0)
        return Evaluation(phi, residual, slope @ jacobian)

    def refuse(self) -> SignalError:
        """The reason why this tick's numbers cannot be computed with, naming the resource."""
        name, (value, reference) = self.controller.feedback.name, self._values()
        try:
            require_finite(reference, f"the reference of {name}")
            require_finite(value, f"the value of {name}")
            require_finite(self._signals.table.rows(self.feedback), f"the Jacobian of {name}")
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
        """The feedback and its reference, as the potential takes them."""
        table = self._signals.table
        return table.values(self.feedback), (
            table.values(self.reference) if self.reference >= 0 else np.zeros(0)
        )

    def _bound(self) -> float:
        """The largest error that earns a reward."""
        within = self.controller.quiescence.within
        if within is None:
            return self._tolerance
        return min(self._tolerance, within * math.hypot(*self._values()[1].tolist()))

    def _draw(self) -> None:
        resource = self.controller.reference
        assert isinstance(resource, Resource)
        if self._sampler is None:
            self._sampler = self._signals.sampler(resource, self._rng)
        self._signals.table.write(self._unmodified, Reading(self._sampler.draw(), None, 0))

    def _change_reference(self) -> None:
        """Write the reference as modifiers change it."""
        table, signals = self._signals.table, self._signals
        if not table.is_defined(self._unmodified):
            table.forget(self.reference)
            return
        record = table.records[self._unmodified]
        value, feedback = table.values(self._unmodified).copy(), table.values(self.feedback).copy()
        for modifier, change in self._modify:
            try:
                value = np.broadcast_to(
                    change(value, feedback, signals.time, dict(modifier.options)), value.shape
                )
            except Exception as error:
                reason = f"{type(error).__name__}: {error}"
                raise MODIFIERS.fault(modifier.name, reason) from error
        # A reference that may move in every tick is as new as the posture.
        table.write(self.reference, Reading(value, None, signals.tips.stamp, record["radius"]))

    def _solve(self) -> None:
        value, goal = self._values()
        require_finite(goal, f"the reference of {self.controller.feedback.name}")
        require_finite(value, f"the value of {self.controller.feedback.name}")
        prepare, field = self._potential.prepare, self.controller.field
        assert prepare is not None
        obstacles = tuple(self._obstacles(field)) if field is not None else ()
        try:
            prepare(value, goal, obstacles, self._parameters)
        except NoPathError as failure:
            self._record["blocked"], self.no_path = True, str(failure)
        else:
            self.no_path = ""

    def _obstacles(self, field: Field) -> Iterator[Obstacle]:
        """Where obstacles are now; what is not seen or felt is not there."""
        for obstacle in field.obstacles:
            if not isinstance(obstacle, Ball):
                lower, upper = np.array(obstacle.lower), np.array(obstacle.upper)
                yield Obstacle(obstacle.name, lower, upper)
                continue
            reading = self._signals.read(obstacle.resource)
            if reading is not None:
                require_finite(reading.value, f"the obstacle {obstacle.resource.name}")
                radius = reading.radius if obstacle.radius is None else obstacle.radius
                yield Obstacle.sphere(obstacle.resource.name, reading.value, radius)

    def _bind_feedback(self) -> int:
        controller, signals = self.controller, self._signals
        source = controller.feedback.source
        if isinstance(controller.reference, AlongNormals):
            assert isinstance(source, (FingerForces, NetForces))
            return signals.bind_normal_forces(source)
        if controller.manipulator is not None:
            assert isinstance(source, EffectorConfiguration)
            return signals.bind_manipulator(
                source.effector, controller.manipulator, controller.joints
            )
        if controller.standoff is not None and isinstance(source, Tip):
            return signals.bind_tip(source, self.reference, controller.standoff)
        return signals.bind(controller.feedback)

    def _bind_reference(self) -> int:
        reference = self.controller.reference
        if reference is None:
            return -1
        if isinstance(reference, Resource):
            if reference.origin is Origin.MODEL:
                return self._signals.bind_written(reference.type.size)
            return self._signals.bind(reference)
        value = self._constant(reference)
        number = self._signals.bind_written(len(value))
        self._signals.table.write(number, Reading(value, None, 0))
        return number

    def _constant(self, reference: Literal | AlongNormals) -> Floats:
        """A constant reference as a row has it."""
        kind, source = self.controller.feedback.type.name, self.controller.feedback.source
        if isinstance(reference, AlongNormals):
            touch = self._signals.touch
            if isinstance(source, FingerForces):
                return reference.force * touch.shares(source.hand)
            assert isinstance(source, NetForces)
            return np.full(len(touch.hands(source.group)), reference.force)
        values = np.array(reference.values)
        if kind == "orientation":
            return exp(values).ravel()
        if kind == "pose":
            return flattened(transform(exp(values[3:]), values[:3]), kind)
        return values

    def _search(self, seek: Seek) -> Search:
        source, until = self.controller.feedback.source, seek.until
        if until is None:
            return Search(seek.once is not None, seek.within, math.nan, ())
        assert isinstance(source, FingerForces)
        joints = self._signals.touch.flexing[source.hand].tolist()
        return Search(seek.once is not None, seek.within, until, joints)
