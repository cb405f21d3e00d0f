"""Runs of the controllers of one program, each made once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from cbdsl.control.plan import ControllerPlan
from cbdsl.program.controller import Composition, Controller, Primitive
from cbdsl.runtime.controller_run import ControllerRun
from cbdsl.runtime.member_lead import MemberLead
from cbdsl.sensing.signals import Signals


class ControllerRuns:
    """Makes one run per controller, however many actions share it.

    Args:
        signals, plan, period: see ``ControllerRun``.
    """

    def __init__(self, signals: Signals, plan: ControllerPlan, period: float) -> None:
        self._context = signals, plan, period
        self._runs: dict[Controller, ControllerRun] = {}

    def run(self, controller: Controller) -> ControllerRun:
        """The run of a controller."""
        if controller not in self._runs:
            self._runs[controller] = ControllerRun(controller, *self._context)
        return self._runs[controller]

    def stack(self, composition: Composition) -> tuple[ControllerRun, ...]:
        """The runs of a composition's controllers, highest priority first."""
        return tuple(map(self.run, reversed(composition.controllers)))

    def waiting(
        self, composition: Composition
    ) -> Iterator[tuple[ControllerRun, Sequence[ControllerRun]]]:
        """Controllers that seek once another has arrived, and those that wait meanwhile.

        That is the whole primitive that the other is a part of. Whether it has come to rest is
        judged from the end of the search, since what is found may set it in motion again.
        """
        for seeker in self.stack(composition):
            seek = seeker.controller.seek
            for primitive in composition.primitives:
                if seek and seek.once in [each.name for each in primitive.controllers]:
                    yield seeker, [self.run(each) for each in primitive.controllers]

    def lead(self, primitive: Primitive, place: int) -> MemberLead:
        """Controllers that give the predicate of a primitive at this place of the state."""
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
        """All runs that were made."""
        return tuple(self._runs.values())
