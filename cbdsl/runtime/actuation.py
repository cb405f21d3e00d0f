"""Actuation: the control law turns the levels of active controllers into joint references."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from cbdsl.backends.staging.links import pairs_without_contact
from cbdsl.control.compiled_tick import RESTED, UNSOUND, ActingArrays, TickArrays, tick
from cbdsl.control.law import Law, LawSettings, Step
from cbdsl.control.plan import ControllerPlan
from cbdsl.control.stack import Stack
from cbdsl.documents.robot import HullSection, RobotDocument
from cbdsl.numeric.arrays import Floats, Integers
from cbdsl.numeric.handle import bind
from cbdsl.program.checked import NO_GUARDS, Guards
from cbdsl.robot.urdf import UrdfError, UrdfModel
from cbdsl.robot.weight import overloads
from cbdsl.runtime.action_levels import Active
from cbdsl.runtime.causes import BLOCKED, CREEPING, OUT_OF_REACH, Balance, RestCause
from cbdsl.runtime.clearance import Clearance
from cbdsl.runtime.controllers.controller_run import ControllerRun
from cbdsl.runtime.load_guards import LoadGuards
from cbdsl.runtime.posture_search import least_error
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.table.signal_rows import Selection
from cbdsl.types.potential import POTENTIALS

# Distance from its limit, beside the law's margin, at which a joint is at it, rad and m.
_AT_LIMIT = 0.01, 0.001
# Named contacts; more would not explain more.
_NAMED = 2

# Controllers, each with the names of its peers, and the conditions that are evaluated.
_Acting = tuple[tuple[tuple[ControllerRun, tuple[str, ...]], ...], tuple[int, ...]]


@dataclass(slots=True)
class ControllerBatch:
    """Controllers that act together, arranged for one compiled call.

    Attributes:
        active: Controllers with their peers, highest priority first.
        runs: Runs of these controllers.
        acting: Rows of slot, slot of the followed controller, slot of the required controller and
            place in the order of priority, required controllers first, shape (runs, 4).
        joints: Indices of the moved joints among all actuated ones, shape (n,).
        columns: The same indices for each controller, -1 for joints it does not move, shape (runs,
            n).
        law: Control law of these joints.
        step: Step of the law, with the stack of the levels.
        selection: Required rows of the signal table.
        prepared: Runs that need preparation before the tick.
        computes: True if a preparation uses the rows of the tick.
        watched: Conditions that are evaluated meanwhile.
        tick: Call of ``tick.tick`` with all arrays, valid while table and plan are of ``versions``.
    """

    active: Sequence[Active]
    runs: tuple[ControllerRun, ...]
    acting: Integers
    joints: Integers
    columns: Integers
    law: Law
    step: Step
    selection: Selection
    prepared: tuple[ControllerRun, ...]
    computes: bool
    watched: tuple[int, ...]
    tick: Callable[[], int] | None = None
    versions: tuple[int, int] = field(default=(-1, -1))

    def begin(self) -> None:
        """Start to act in place of other controllers."""
        # The Jacobians of earlier ticks belong to another time, so they must not be extrapolated.
        self.step.stack.forget()
        for run, columns in zip(self.runs, self.columns, strict=True):
            run.columns = columns


class Actuation:
    """Integrator of the law's displacements into joint references.

    Attributes:
        settings: Guards of the law for ticks of this length.
        load_guards: Bounds on the loads of fingers, hands and arms.
        clearance: Bound on the distances of links.
        reference: Position references of all actuated joints, rad, shape (n,).
        step: Step of the last tick's levels, or ``None`` if no controller acted.
    """

    def __init__(
        self,
        robot: RobotDocument,
        signals: Signals,
        plan: ControllerPlan,
        period: float,
        guards: Guards = NO_GUARDS,
    ) -> None:
        control = robot.control
        self._robot, self._signals, self._plan, self._period = robot, signals, plan, period
        # The robot's settings are for its own rate. In a longer tick the joints move farther and
        # their Jacobians change more, so damping and singular value grow with the tick.
        longer = period * control.rate
        self.settings = LawSettings(
            damping=control.damping * longer**2,
            singular_value=control.singular_value * longer,
            joint_step=control.joint_speed * period,
            limit_margin=control.limit_margin,
            lead=control.lead,
        )
        self._steps = _encoder_steps(robot, signals.joints.names)
        self.reference: Floats = np.zeros(len(signals.joints))
        self._hulls: Mapping[str, HullSection] = {}
        self.guard(guards)

    def guard(self, guards: Guards) -> None:
        """Bound loads and distances by other guards from now on.

        Fixtures keep the hulls of the stage, which an edited program does not know.
        """
        self._hulls = {**self._hulls, **guards.hulls}
        known = {name: self._hulls[name] for name in guards.fixtures if name in self._hulls}
        guards = guards._replace(hulls=known)
        self.load_guards = LoadGuards(guards, self._signals, self._period)
        self.clearance = Clearance(guards, self._signals, self._period)
        self._batches: dict[_Acting, ControllerBatch] = {}
        self._forget()

    def drop_replaced(self) -> None:
        """Free the arrays of all controllers but the last active ones, which may go on."""
        self._batches = {runs: each for runs, each in self._batches.items() if each is self._last}

    def reset(self, positions: Floats) -> None:
        """Start from measured positions, rad, shape (n,)."""
        self.reference[:] = positions
        self._forget()

    def resume(self, reference: Floats) -> None:
        """Start from the references of the last episode, rad, shape (n,)."""
        self.reference[:] = reference
        self._forget()

    def _forget(self) -> None:
        """Forget the last active controllers."""
        self.load_guards.reset()
        self.clearance.reset()
        self.step: Step | None = None
        self._last: ControllerBatch | None = None

    def move(self, active: Sequence[Active]) -> None:
        """Evaluate the active controllers and move the references by the law's step.

        Raises:
            SignalError: If an input of a controller is not finite; the references have not moved.
        """
        self.step, batch = None, self._take_over(active)
        if batch is None:
            return
        # The compiled tick refreshes the rows of the signal table itself. They are refreshed here
        # only if a preparation in Python needs the numbers of this tick.
        if batch.computes:
            self._signals.refresh(batch.selection)
        else:
            self._signals.refresh_read(batch.selection)
            self._signals.kinematics.place()
        for run in batch.prepared:
            run.prepare()
        self.load_guards.note_strain()
        self.clearance.place_seen()
        # A bound call holds addresses of arrays. They change if the table or the plan grows, and
        # the call is then bound again.
        versions = self._signals.table.version, self._plan.version
        if batch.tick is None or batch.versions != versions:
            batch.tick, batch.versions = self._bind(batch), versions
        try:
            outcome = batch.tick()
        except Exception as error:  # our own kernels raise none
            fault = _fault_of(batch.runs, error)
            raise (fault or error) from (error if fault else None)
        # A positive number or 0 is the place of the controller whose numbers are not finite.
        if outcome >= 0:
            raise batch.runs[outcome].refuse()
        if outcome == UNSOUND:
            batch.step.require_sound(self._signals.positions[batch.joints])
        self.step = None if outcome == RESTED else batch.step
        self.load_guards.note()
        self.clearance.note()

    def _take_over(self, active: Sequence[Active]) -> ControllerBatch | None:
        """Return the controllers that act from now on; ``None`` if the program has ended."""
        last = self._last
        watched = self._plan.conditions.watched
        if last is None or active is not last.active or watched is not last.watched:
            self._last = batch = self._batch(active) if active else None
            if batch is not None:
                batch.active = active
                if batch is not last:
                    batch.begin()
        return self._last

    def balance(self, names: Sequence[str] = ()) -> Balance | None:
        """Return the balance of the last tick's levels; ``None`` if no controller acted.

        Args:
            names: Names of the levels, highest priority first; their controllers' by default.
        """
        step, batch = self.step, self._last
        if step is None or batch is None:
            return None
        levels = names or [level.name for level in step.levels]
        joints = [self._signals.joints.names[joint] for joint in batch.joints]
        outward, apart = self._outward(step, batch.joints), self.clearance.pressing(batch.joints)
        return Balance(step, levels, joints, outward, apart)

    def _outward(self, step: Step, joints: Integers) -> Floats:
        """Return 1 for a joint that its upper limit holds back, -1 for its lower one, else 0."""
        kinematics, margin = self._signals.kinematics, self.settings.limit_margin
        here = self._signals.positions[joints]
        # A locked joint may still be on its way to the limit.
        near = margin + np.where(kinematics.slides[joints], _AT_LIMIT[1], _AT_LIMIT[0])
        upper = (here >= kinematics.upper[joints] - near).astype(float)
        lower = (here <= kinematics.lower[joints] + near).astype(float)
        outward: Floats = np.where(step.locked, upper - lower, 0.0)
        return outward

    def cause(self, run: ControllerRun) -> RestCause | None:
        """Return the cause that keeps a controller at rest from its target; ``None`` if unknown."""
        balance, batch = self.balance(), self._last
        if balance is None or batch is None or run not in batch.runs:
            return None
        place = int(np.count_nonzero(balance.step.stack.ages[: batch.runs.index(run)]))
        cause = balance.cause(place) or RestCause(CREEPING)
        if cause.kind == CREEPING:
            # The displacement of this tick is still ahead of joints that follow.
            lag = (self.reference - self._signals.positions)[batch.joints]
            behind = np.abs(lag - balance.step.displacement) > 0.5 * self.settings.lead
            joints = tuple(name for name, late in zip(balance.joints, behind, strict=True) if late)
            if not joints:
                return RestCause(CREEPING)
            names, here = self._signals.joints.names, self._signals.positions
            positions = dict(zip(names, here.tolist(), strict=True))
            model = self._signals.kinematics.model
            reasons = obstructions(self._robot, model, positions, joints)
            return RestCause(BLOCKED, joints=joints, obstructions=reasons)
        least = least_error(run, self._signals, self.settings.limit_margin)
        if least > run.controller.arrival[0]:
            return RestCause(OUT_OF_REACH, least=least)
        return cause._replace(least=least)

    def at_limits(self) -> tuple[str, ...]:
        """Return the joints held back by their limits in the last tick."""
        balance = self.balance()
        if balance is None:
            return ()
        sides = zip(balance.joints, balance.outward, strict=True)
        return tuple(name for name, side in sides if side)

    def _bind(self, batch: ControllerBatch) -> Callable[[], int]:
        """Return a call of the tick with the current arrays of table and plan."""
        signals, step = self._signals, batch.step
        needed = batch.selection.compiled
        arrays = TickArrays(
            signals.arrays,
            self._plan.arrays,
            ActingArrays(
                needed,
                signals.clock,
                batch.acting,
                batch.columns,
                batch.joints,
                self._steps[batch.joints],
                np.array(batch.watched, dtype=np.int64),
            ),
            step.stack.arrays,
            batch.law.arrays(step),
            self.reference,
            self.load_guards.records,
            self.clearance.arrays,
        )
        return bind(tick, arrays)

    def _batch(self, active: Sequence[Active]) -> ControllerBatch:
        """Return the batch of the active controllers, allocated when they first act together."""
        runs = tuple([(item.run, tuple(item.peers)) for item in active])
        key = runs, self._plan.conditions.watched
        batch = self._batches.get(key)
        if batch is None:
            batch = self._batches[key] = self._allocate(active)
        return batch

    def _allocate(self, active: Sequence[Active]) -> ControllerBatch:
        """Return a new batch with the active controllers' levels and the union of their joints."""
        signals, runs = self._signals, tuple([item.run for item in active])
        names = tuple(dict.fromkeys(joint for run in runs for joint in run.controller.joints))
        joints, limits = signals.joints.pick(names), signals.kinematics
        stack = Stack([(run.controller.name, run.size) for run in runs], len(joints))
        rows = [row for run in runs for row in run.needs] + self.load_guards.rows
        rows += [*self._plan.conditions.rows(), *self.clearance.rows]
        return ControllerBatch(
            active,
            runs,
            np.array(_required_first(active)),
            joints,
            np.array([np.where(np.isin(joints, run.own), joints, -1) for run in runs]),
            Law(
                limits.lower[joints],
                limits.upper[joints],
                self.settings,
                self._period * limits.speed[joints],
            ),
            Step.of(stack),
            signals.select(rows),
            tuple([run for run in runs if run.preparation.is_needed]),
            any([run.preparation.computes for run in runs]),
            self._plan.conditions.watched,
        )


def _encoder_steps(robot: RobotDocument, joints: Sequence[str]) -> Floats:
    """Return the steps of the joints' encoders, rad or m, shape (n,)."""
    of = {name: each.resolution for each in robot.effectors.values() for name in each.joints}
    return np.array([of.get(name, 0.0) for name in joints])


def _fault_of(runs: Sequence[ControllerRun], error: Exception) -> Exception | None:
    """Return the fault of the first plug-in potential in use; ``None`` without one."""
    for name in dict.fromkeys(run.controller.potential for run in runs):
        if not POTENTIALS.registry.is_builtin(name):
            return POTENTIALS.registry.fault(name, f"{type(error).__name__}: {error}")
    return None


def _required_first(active: Sequence[Active]) -> list[tuple[int, int, int, int]]:
    """Return the rows of ``ControllerBatch.acting``, by priority as far as requirements allow.

    A required controller is decided in the same tick before the controllers that require it.
    """
    rows = {item.run.slot: (*_peers(item), place) for place, item in enumerate(active)}
    ordered: dict[int, None] = {}
    for slot in rows:
        chain = [slot]
        # A circle of requirements ends the chain, and so does a controller that is placed already.
        while (required := rows[chain[-1]][1]) >= 0 and required not in (*chain, *ordered):
            chain.append(required)
        ordered.update(dict.fromkeys(reversed(chain)))
    return [(slot, *rows[slot]) for slot in ordered]


def _peers(item: Active) -> tuple[int, int]:
    """Return the slots of the followed and the required controller; -1 if it does not act."""
    controller = item.run.controller
    seek = controller.seek
    return _slot(item.peers, seek.once if seek else None), _slot(item.peers, controller.requires)


def _slot(peers: Mapping[str, ControllerRun], name: str | None) -> int:
    return peers[name].slot if name is not None and name in peers else -1


def obstructions(
    robot: RobotDocument, model: UrdfModel, positions: Mapping[str, float], joints: Iterable[str]
) -> tuple[str, ...]:
    """Return weights beyond efforts, and contacts of links, that keep joints from following.

    Args:
        robot: Robot document, with efforts and pairs of links that touch nothing.
        model: Model of the robot.
        positions: Measured positions of joints, rad or m.
        joints: Joints that do not follow their references.
    """
    late = tuple(joints)
    try:
        return (*_weights(robot, model, positions, late), *_contacts(robot, model, positions, late))
    except (ImportError, UrdfError):  # meshes need coal, which comes with Pinocchio
        return ()


def _weights(
    robot: RobotDocument, model: UrdfModel, positions: Mapping[str, float], late: tuple[str, ...]
) -> list[str]:
    efforts = {
        name: min(robot.simulation.efforts.get(name, math.inf), model.joints[name].effort)
        for name in late
    }
    over = overloads(model, positions, efforts)
    return [
        f"{name} bears {needed:.3g} of {most:.3g} {'N' if model.joints[name].slides else 'N m'}"
        for name, (needed, most) in over.items()
    ]


def _contacts(
    robot: RobotDocument, model: UrdfModel, positions: Mapping[str, float], late: tuple[str, ...]
) -> list[str]:
    from cbdsl.kinematics.self_contacts import SelfContacts  # only a blocked arm needs it

    ignored = pairs_without_contact(robot, model)
    touching = [
        f"{one} touches {other}"
        for one, other in sorted(SelfContacts(model).touching(positions) - ignored)
        if not {*model.above(one)}.symmetric_difference(model.above(other)).isdisjoint(late)
    ]
    return touching[:_NAMED]
