"""Runs of the controllers of one program, each created once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from cbdsl.control.plan import ControllerPlan
from cbdsl.program.controller import AlongNormals, Composition, Controller, Primitive, Relative
from cbdsl.runtime.controllers.controller_run import ControllerRun
from cbdsl.sensing.signals import Signals
from cbdsl.types.resource import Resource
from cbdsl.types.source_record import Normals, is_located, normals_of


class MemberLead(NamedTuple):
    """Leading controller of a member, and the lower controllers that it waits for.

    Attributes:
        place: Index of the member in the state.
        run: Run of the controller with the highest priority.
        awaited: Runs that must rest first: controllers without a reference, whose only goal is
            rest, and controllers that a reward depends on.
        earners: Runs of the rewarded controllers; empty if no reward is possible.
        conditions: Runs that have to be at rest for a reward, but earn none.
    """

    place: int
    run: ControllerRun
    awaited: tuple[ControllerRun, ...]
    earners: tuple[ControllerRun, ...]
    conditions: tuple[ControllerRun, ...] = ()

    @property
    def predicate(self) -> str:
        """Predicate of the leading controller; at rest only if the awaited controllers are, too."""
        leading = self.run.predicate
        for run in self.awaited if leading == "1" else ():
            # A controller that only optimizes may be undefined without delaying the member. One
            # that a reward depends on must be at rest.
            needed = run in self.earners or run in self.conditions
            if run.predicate == "0" or (needed and run.predicate != "1"):
                return "0"
        return leading

    @property
    def arrived(self) -> bool:
        """True if the member is at rest, and its leading controller within its tolerance."""
        return self.predicate == "1" and self.run.arrived

    @property
    def stuck(self) -> bool:
        """True if the member is at rest, and its leading controller beyond its tolerance."""
        return self.predicate == "1" and self.run.stuck

    @property
    def is_earned(self) -> bool:
        """True if all controllers that its reward depends on are at rest within their bounds."""
        if not self.earners:
            return False
        needed = (*self.earners, *self.conditions)
        return all([run.predicate == "1" and run.settled for run in needed])


class ControllerRuns:
    """Factory of one run per controller, even if several actions share it.

    Args:
        signals, plan, period: Arguments of ``ControllerRun``.
    """

    def __init__(self, signals: Signals, plan: ControllerPlan, period: float) -> None:
        self._context = signals, plan, period
        self._runs: dict[Controller, ControllerRun] = {}
        self._before: Mapping[Controller, ControllerRun] = {}

    def successor(self) -> ControllerRuns:
        """Return a factory that goes on with the runs of this one where controllers are equal."""
        after = ControllerRuns(*self._context)
        after._before = self._runs
        return after

    def run(self, controller: Controller) -> ControllerRun:
        """Return the run of a controller."""
        if controller not in self._runs:
            kept = self._before.get(controller)
            self._runs[controller] = kept or ControllerRun(controller, *self._context)
        return self._runs[controller]

    def stack(self, composition: Composition) -> tuple[ControllerRun, ...]:
        """Return the runs of a composition's controllers, highest priority first."""
        return tuple(map(self.run, reversed(composition.controllers)))

    def waiting(
        self, composition: Composition
    ) -> Iterator[tuple[ControllerRun, Sequence[ControllerRun]]]:
        """Yield each controller that seeks once another has arrived, with the waiting controllers.

        The whole primitive of the other controller waits. Its rest is judged from the end of the
        search, because the search result may set it in motion again.
        """
        for seeker in self.stack(composition):
            seek = seeker.controller.seek
            for primitive in composition.primitives:
                if seek and seek.once in [each.name for each in primitive.controllers]:
                    yield seeker, [self.run(each) for each in primitive.controllers]

    def aim(self) -> None:
        """Let contacts that are sought at a seen object count only there.

        A controller that seeks once another has arrived touches the object that the other reaches
        for, and not the table beside it.
        """
        named = {run.controller.name: run for run in self._runs.values()}
        for run in self._runs.values():
            controller = run.controller
            goal = named.get(controller.seek.once or "") if controller.seek else None
            if goal is not None and _sees(goal.controller) and _feels_each_finger(controller):
                run.aim(goal.rows.reference)

    def lead(self, primitive: Primitive, place: int) -> MemberLead:
        """Return the controllers that determine a primitive's predicate at a place of the state."""
        # The last controller has the highest priority; it is not awaited, because it leads.
        optimising = [each for each in primitive.controllers[:-1] if each.reference is None]
        awaited = dict.fromkeys((*optimising, *primitive.earners, *primitive.conditions))
        awaited.pop(primitive.lead, None)
        others, earners, conditions = (
            tuple(self.run(controller) for controller in some)
            for some in (awaited, primitive.earners, primitive.conditions)
        )
        return MemberLead(place, self.run(primitive.lead), others, earners, conditions)

    @property
    def all(self) -> tuple[ControllerRun, ...]:
        """All runs created so far."""
        return tuple(self._runs.values())


def _sees(controller: Controller) -> bool:
    """Return whether the reference of a controller is the position of a seen object."""
    reference = controller.reference
    base = reference.base if isinstance(reference, Relative) else reference
    return isinstance(base, Resource) and is_located(base.source)


def _feels_each_finger(controller: Controller) -> bool:
    """Return whether a controller compares the forces along the normals of a hand's fingers."""
    along = isinstance(controller.reference, AlongNormals)
    return along and normals_of(controller.feedback) is Normals.FINGERS
