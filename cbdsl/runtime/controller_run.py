"""One controller while it runs: from signals to a level of the law and a predicate."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.body import Body
from cbdsl.control.composition import Integers
from cbdsl.control.field import NoPathError
from cbdsl.control.kernel import DONE, ERROR, FOLLOW, PHI, RAISED, REST, SEEK
from cbdsl.control.member import Member
from cbdsl.control.obstacle import Obstacle
from cbdsl.control.potential import Evaluation
from cbdsl.control.predicate import QuiescenceMonitor
from cbdsl.control.registry import build
from cbdsl.control.rotation import exp
from cbdsl.control.signal import Signal
from cbdsl.control.stack import Stack
from cbdsl.control.task import Task
from cbdsl.program.controller import AlongNormals, Ball, Controller, Field, Funnel, Literal
from cbdsl.sensing.density import Sampler
from cbdsl.sensing.reading import Reading, transform
from cbdsl.sensing.selection import columns_of, columns_of_both, responds
from cbdsl.sensing.signals import Signals
from cbdsl.types.resource import (
    EffectorConfiguration,
    FingerForces,
    Heading,
    Headings,
    NetForces,
    Origin,
    Posture,
    Resource,
    StereoPosition,
    Tip,
)

Floats = NDArray[np.float64]

_SEEN = (Heading, Headings, StereoPosition)
_FELT = (FingerForces, NetForces)
_PROPRIOCEPTIVE = (Tip, EffectorConfiguration)
_NOTHING = Reading(np.zeros(0), np.zeros((0, 0)), 0)


class ControllerRun:
    """A controller's state between its activation and its deactivation.

    Attributes:
        controller: what runs.
        own: indices of the effector's joints among all actuated ones, shape (m,).
        member: what the compiled tick knows of it.
        seeking: whether it acts to make its feedback defined.
        exhausted: whether it has sought in vain.
        no_path: why no free path leads to the reference; empty where one does.
    """

    def __init__(self, controller: Controller, signals: Signals, period: float) -> None:
        self.controller = controller
        self._signals = signals
        own = self.own = signals.joints.pick(controller.joints)
        self._read = _reader(controller, signals)
        limits = signals.kinematics
        cameras = (
            signals.sight.cameras() if isinstance(controller.feedback.source, Headings) else ()
        )
        self._potential = build(controller, Body(limits.lower[own], limits.upper[own], cameras))
        self._task = Task(controller, self._potential, period)
        quiescence = controller.quiescence
        self._monitor = QuiescenceMonitor(quiescence.rate, quiescence.window, period)
        self._tolerance = math.inf if quiescence.tolerance is None else quiescence.tolerance
        self.member = Member(self._potential, self._task, self._monitor, len(signals.joints))
        self._constant = _constant_reference(controller, signals)
        # What may be undefined is asked anew in every tick.
        self._follows_joints = controller.requires is None and self._can_follow_joints()

    def begin(self, rng: np.random.Generator) -> None:
        """Begin an episode, in which ``rng`` is for all that is drawn."""
        self._rng = rng
        self._sampler: Sampler | None = None
        self._moves = self._always_defined = False
        self.deactivate()
        if self.needs_nothing:
            self.member.duty = FOLLOW

    def deactivate(self) -> None:
        """Forget the activation."""
        constant = self._against = self._constant
        self._is_aimed = constant is not None and self.member.aim(constant)
        self._is_forgotten = False
        self.member.forget()
        self.seeking = self.exhausted = self._engaged = False
        self.no_path = ""
        self._sample: Reading | None = None
        self._task.reset()
        self._monitor.reset()

    def activate(self) -> None:
        """Start anew where it was idle or at rest on a sample; otherwise go on."""
        sampled = self._sample is not None and self.predicate == "1"
        if self.predicate == "X" or sampled:
            self.deactivate()
            self.predicate = "0"

    def unsettle(self) -> None:
        """Judge rest anew, by what the potential does from now on."""
        self._monitor.unsettle()

    @property
    def predicate(self) -> str:
        """X - 0 1 (Eq 4.1)."""
        return self._monitor.predicate

    @predicate.setter
    def predicate(self, predicate: str) -> None:
        self._monitor.predicate = predicate

    @property
    def phi(self) -> float:
        """The potential, NaN while undefined."""
        phi: float = self.member.outcome.item(PHI)
        return phi

    @property
    def error(self) -> float:
        """Norm of the residual in the unit of the feedback, NaN while undefined."""
        error: float = self.member.outcome.item(ERROR)
        return error

    @property
    def size(self) -> int:
        """Number of task coordinates."""
        return self._potential.size

    def join(self, stack: Stack, place: int, columns: Integers) -> None:
        """Act in a composition from now on.

        Args:
            stack: of the composition.
            place: of its level in the stack.
            columns: which joint each of the stack's n is, -1 for those that count as still.
        """
        self._stack, self._place, self._columns = stack, place, columns
        self._task.join(stack, place, columns)

    @property
    def needs_nothing(self) -> bool:
        """Whether its reference is constant and its feedback the posture: nothing is to be read."""
        return self._constant is not None and self._is_aimed and self._follows_joints

    @property
    def engaged(self) -> bool:
        """Whether it is defined, or was and seeks to be again."""
        return self._engaged or self.needs_nothing

    @property
    def asks(self) -> bool:
        """Whether it looks at what the others that act with it have come to."""
        return self.controller.seek is not None and self.controller.seek.once is not None

    def sense(self, peers: Mapping[str, ControllerRun]) -> bool:
        """Take in this tick's signals; returns whether it acts.

        Args:
            peers: the controllers it runs together with, by name.

        Raises:
            SignalError: a number that it would act on is not finite; the message names it.
        """
        # Its joints are read where it acts.
        if self._is_aimed and self._follows_joints:
            return True
        acts = self._sensed(peers)
        if not acts:
            self.member.duty = REST
        return acts

    def _sensed(self, peers: Mapping[str, ControllerRun]) -> bool:
        reference = (self._constant or self._reference()) if self._is_given(peers) else None
        if reference is None:
            self._undefined()
            self._engaged = False
            return False
        feedback = self._measured(reference)
        defined = feedback is not None
        if feedback is None:
            self._undefined()
            feedback = self._read(reference) if self._may_seek(peers) else None
        if feedback is None:
            self._engaged = False
            return False
        return self._feel(feedback, reference, defined=defined)

    def _feel(self, feedback: Reading, reference: Reading, *, defined: bool) -> bool:
        """Hand signals on to the compiled tick, or act by them at once."""
        wanted, funnel, raised = reference.value, self.controller.funnel, 0.0
        if funnel is not None:
            raised = _height(wanted, feedback.value, funnel)
        stamp = max(feedback.stamp, reference.stamp)
        fits = self._is_aimed or self.member.aim(reference)
        if not (fits and self.member.feel(feedback, stamp, raised)):
            return self._follow(feedback, reference, raised, defined=defined)
        self.member.duty = FOLLOW if defined else SEEK
        self._is_forgotten = False
        if defined:
            self._defined(reference)
        return True

    def evaluate(self) -> None:
        """Act by itself in this tick, where the compiled tick could not.

        Raises:
            SignalError: a number that it would act on is not finite; the message names it.
        """
        reference = self._constant or self._reference()
        assert reference is not None
        feedback = self._read(reference)
        assert feedback is not None
        duty, raised = self.member.duty, self.member.outcome.item(RAISED)
        self._follow(feedback, reference, raised, defined=duty == FOLLOW)
        self.member.duty = duty

    def _follow(
        self, feedback: Reading, reference: Reading, raised: float, *, defined: bool
    ) -> bool:
        """Write this tick's level and judge by it; returns whether there is one."""
        try:
            phi, error = self._acted(feedback, reference.value, raised)
        except NoPathError as failure:
            self._undefined()
            self._is_forgotten = self._engaged = False
            self.no_path = str(failure)
            return False
        self.member.duty = DONE
        self._is_forgotten = False
        if defined:
            self._defined(reference)
            self.member.outcome[:RAISED] = phi, error
            self._monitor.update(phi, max(feedback.stamp, reference.stamp))
        return True

    def _acted(self, feedback: Reading, wanted: Floats, raised: float) -> tuple[float, float]:
        """Write this tick's level; returns phi and the norm of the residual."""
        phi, error = self._task.act(feedback, wanted, raised)
        if not math.isnan(phi):
            return phi, error
        signal = self._signal(feedback)
        judged = acting = self._potential.evaluate(signal, wanted)
        if raised > 0.0:
            acting = self._potential.evaluate(signal, wanted + np.array([0.0, 0.0, raised]))
        self._stack.put(self._place, self._task.level(acting))
        return judged.phi, math.sqrt(judged.residual.dot(judged.residual))

    @property
    def evaluation(self) -> Evaluation | None:
        """The potential in this tick, in the joints that act; ``None`` while undefined."""
        against = self._against
        feedback = None if against is None or math.isnan(self.phi) else self._read(against)
        if against is None or feedback is None:
            return None
        return self._potential.evaluate(self._signal(feedback), against.value)

    def _signal(self, feedback: Reading) -> Signal:
        """The feedback as the effector's joints move it; all others count as still (Eq 3.21)."""
        curvature, field = feedback.curvature, self.controller.field
        return Signal(
            self.controller.feedback.name,
            feedback.value,
            columns_of(feedback.jacobian, self._columns),
            None if curvature is None else columns_of_both(curvature, self._columns),
            () if field is None else tuple(self._obstacles(field)),
        )

    def _obstacles(self, field: Field) -> Iterator[Obstacle]:
        """Where obstacles are now; what is not seen or felt is not there."""
        for obstacle in field.obstacles:
            if not isinstance(obstacle, Ball):
                lower, upper = np.array(obstacle.lower), np.array(obstacle.upper)
                yield Obstacle(obstacle.name, lower, upper)
                continue
            reading = self._signals.read(obstacle.resource)
            if reading is not None:
                radius = reading.radius if obstacle.radius is None else obstacle.radius
                yield Obstacle.sphere(obstacle.resource.name, reading.value, radius)

    def _measured(self, reference: Reading) -> Reading | None:
        """The feedback, if it is measured and the effector moves it.

        What is seen moves with an arm only while the arm's hand holds it; all else always does.
        """
        if self._always_defined:
            return self._read(reference)
        source = self.controller.feedback.source
        # Forces along normals can be read without contact, too.
        if isinstance(source, _FELT) and not self._signals.defined(self.controller.feedback):
            return None
        feedback = self._read(reference)
        if feedback is None:
            return None
        moves = self._moves or responds(feedback.jacobian, self.own)
        self._moves = moves and not isinstance(source, _SEEN)
        self._always_defined = self._moves and isinstance(source, _PROPRIOCEPTIVE)
        return feedback if moves else None

    def _undefined(self) -> None:
        if self._is_forgotten:
            return
        self._monitor.undefined()
        self.member.forget()
        self.no_path = ""
        # The robot may be doing something else by the time the signal is back.
        if not self.seeking:
            self._task.reset()
            self._is_forgotten = True

    def _defined(self, reference: Reading) -> None:
        self.seeking = self.exhausted = False
        self._engaged = True
        self.no_path = ""
        self._against = reference

    @property
    def settled(self) -> bool:
        """Whether it is defined and its error small enough to earn a reward."""
        return self._against is not None and self.error <= self._bound(self._against)

    def _bound(self, reference: Reading) -> float:
        """The largest error that earns a reward."""
        within = self.controller.quiescence.within
        if within is None:
            return self._tolerance
        return min(self._tolerance, within * math.hypot(*reference.value.ravel().tolist()))

    def _can_follow_joints(self) -> bool:
        """Have the posture as feedback, if it is one that the effector moves."""
        controller, member = self.controller, self.member
        source = controller.feedback.source
        if not isinstance(source, EffectorConfiguration) or controller.manipulator is not None:
            return False
        joints = self._signals.joints.of(source.effector)
        can = len(joints) == len(member.value) and bool(np.isin(joints, self.own).any())
        if can:
            member.follow_joints(joints)
        return can

    def _is_given(self, peers: Mapping[str, ControllerRun]) -> bool:
        """Whether the controller without which it is undefined is engaged, if there is one."""
        required = self.controller.requires
        if required is None:
            return True
        condition = peers.get(required)
        return condition is not None and condition.engaged

    def _may_seek(self, peers: Mapping[str, ControllerRun]) -> bool:
        """Whether to act although the feedback is undefined."""
        seek = self.controller.seek
        if seek is None:
            return False
        if not self.seeking and not self.exhausted:
            leader = peers.get(seek.once) if seek.once is not None else None
            self.seeking = seek.once is None or (leader is not None and leader.error < seek.within)
        if self.seeking and seek.until is not None and self._flexed(seek.until):
            self.seeking, self.exhausted = False, True
        return self.seeking

    def _flexed(self, until: float) -> bool:
        source = self.controller.feedback.source
        assert isinstance(source, FingerForces)
        joints = self._signals.touch.flexing[source.hand]
        return bool((self._signals.positions[joints] > until).all())

    def _reference(self) -> Reading | None:
        """The reference now, where it is not constant, or ``None`` while it is undefined."""
        resource = self.controller.reference
        assert isinstance(resource, Resource)
        if resource.origin is not Origin.MODEL:
            return self._signals.read(resource)
        if self._sample is None:
            if self._sampler is None:
                self._sampler = self._signals.sampler(resource, self._rng)
            self._sample = Reading(self._sampler.draw(), np.zeros((0, 0)), 0)
            self._is_aimed = self.member.aim(self._sample)
        return self._sample


def _reader(controller: Controller, signals: Signals) -> Callable[[Reading], Reading | None]:
    """What reads the feedback, given the reference."""
    feedback, source = controller.feedback, controller.feedback.source
    tips, touch = signals.tips, signals.touch
    if isinstance(source, (FingerForces, NetForces)) and isinstance(
        controller.reference, AlongNormals
    ):
        return lambda reference: touch.normal_forces(source)
    if controller.manipulator is not None:
        assert isinstance(source, EffectorConfiguration)
        effector, part = source.effector, controller.manipulator
        return lambda reference: tips.manipulator(effector, part)
    if controller.standoff is not None and isinstance(source, Tip):
        clearance, least, most = controller.standoff
        return lambda reference: tips.tip(
            source, min(max(reference.radius + clearance, least), most)
        )
    return lambda reference: signals.read(feedback)


def _constant_reference(controller: Controller, signals: Signals) -> Reading | None:
    reference, source = controller.reference, controller.feedback.source
    if isinstance(reference, AlongNormals):
        assert isinstance(source, (FingerForces, NetForces))
        shares = _shares(source, signals)
        return Reading(reference.force * shares, np.zeros((0, 0)), 0)
    if isinstance(reference, Literal):
        values = np.array(reference.values)
        if controller.feedback.type.name == "orientation":
            values = exp(values)
        elif controller.feedback.type.name == "pose":
            values = transform(exp(values[3:]), values[:3])
        return Reading(values, np.zeros((0, 0)), 0)
    if reference is None:
        return _NOTHING
    return signals.read(reference) if isinstance(reference.source, Posture) else None


def _shares(source: FingerForces | NetForces, signals: Signals) -> Floats:
    """How a force along normals is shared out among the fingers, or given to each hand."""
    if isinstance(source, FingerForces):
        return signals.touch.shares(source.hand)
    return np.ones(len(signals.touch.hands(source.group)))


def _height(reference: Floats, position: Floats, funnel: Funnel) -> float:
    """How far above its reference an approach begins: the farther, the larger the lateral error."""
    (x, y, _), (own_x, own_y, _) = reference.tolist(), position.tolist()
    lateral = math.hypot(x - own_x, y - own_y)
    return min(max(funnel.slope * (lateral - funnel.within), 0.0), funnel.height)
