"""Rewards of a program's transitions, and the outcomes that its states state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.runtime.action_levels import ActionLevels
from cbdsl.runtime.action_runs import ChildRun
from cbdsl.types.state import ARRIVED, STUCK, Predicate, matches


class Conclusion(NamedTuple):
    """Outcome of a program by its state.

    Attributes:
        outcome: ``success`` or ``failure``.
        reason: Reason of a failure, as a clause; may be empty.
    """

    outcome: str
    reason: str


class Rewards:
    """Rules that reward or conclude a program.

    Args:
        program: Program with the members.
        levels: Controllers of its actions.
        children: Runs of its subprograms, by action.
    """

    def __init__(
        self, program: CheckedProgram, levels: ActionLevels, children: Mapping[str, ChildRun]
    ) -> None:
        self._program, self._levels, self._children = program, levels, children

    def rewarding(self, action: Action, before: str, after: str) -> tuple[str, ...]:
        """Return the members that newly quiesce on a signal from the environment (Eq 4.2-4.4).

        A program in the place of a rewarded controller is rewarded in the same way.

        Args:
            action: Action that ran.
            before: State before.
            after: State after.
        """
        own = tuple(
            self._program.members[lead.place]
            for lead in self._levels.leads.get(action.name, ())
            if after[lead.place] == "1" != before[lead.place] and lead.is_earned
        )
        stood_for = self._program.primitives.get(action.part)
        child = self._children.get(action.name)
        if child is None or stood_for is None or not stood_for.rewarded or not child.rewarded:
            return own
        place = self._program.members.index(action.part)
        return (*own, action.part) if after[place] == "1" != before[place] else own

    def stuck(self, action: Action) -> tuple[str, ...]:
        """Return the members of a running action that are at rest beyond their tolerance."""
        leads = self._levels.leads.get(action.name, ())
        return tuple(self._program.members[lead.place] for lead in leads if lead.stuck)

    def with_rests(self, state: str, stuck: Sequence[str]) -> str:
        """Return a state with other letters for rest within and beyond the tolerance."""
        members = self._program.members
        rests = (STUCK if member in stuck else ARRIVED for member in members)
        pairs = zip(state, rests, strict=True)
        return "".join(rest if own == Predicate.QUIESCENT else own for own, rest in pairs)

    def conclusion(self, state: str, stuck: Sequence[str] = ()) -> Conclusion | None:
        """Return the outcome that a state stands for, or ``None``; success comes first.

        Args:
            state: State of the program.
            stuck: Members at rest beyond their tolerance, whose rest is no success.
        """
        program = self._program
        state = self.with_rests(state, stuck)
        successes = [pattern for pattern in program.success if matches(pattern, state)]
        # An explicit rest asks for arrival.
        strict = (pattern.replace(Predicate.QUIESCENT, ARRIVED) for pattern in successes)
        if any(matches(pattern, state) for pattern in strict):
            return Conclusion("success", "")
        for pattern in program.failure:
            if matches(pattern, state):
                return Conclusion("failure", program.reasons.get(pattern, ""))
        return Conclusion("failure", "") if successes else None

    def final(self, state: str, stuck: Sequence[str] = (), *, changed: bool, is_done: bool) -> str:
        """Return the program's own predicate at the end of its policy.

        A program without rewardable members succeeds when its last action is quiescent within its
        tolerances. One that states its success achieves nothing else.

        Args:
            state: Last state.
            stuck: Members at rest beyond their tolerance.
            changed: True if the last transition changed the state.
            is_done: True if the program was rewarded, and a reward does not end it.
        """
        if self._program.success:
            return "-"
        if is_done:
            return "1"
        leads = (lead for some in self._levels.leads.values() for lead in some)
        rewardable = any(lead.earners for lead in leads)
        acting = state[: len(state) - len(self._program.conditions)]
        return "1" if changed and not rewardable and "1" in acting and not stuck else "-"
