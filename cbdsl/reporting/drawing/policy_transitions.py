"""States of a policy, their actions, and the observed transitions between them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.policy import PolicyDocument
from cbdsl.types.state import ANY, PREDICATES

#: Arcs of a larger share are drawn, as in the figures of Chapter 4.
ABOVE = 0.2

_LETTERS = frozenset(PREDICATES + ANY)


class Decision(NamedTuple):
    """Action of a policy in a state, and its observed effects.

    Attributes:
        state: State, one letter per member; in written policies also ``*``, which stands for any.
        action: Action, or ``None`` if the policy has none for this state.
        value: Expected discounted reward of the action, or ``None`` if nothing was learned.
        tried: Number of trials of the action.
        met: Number of visits to the state, regardless of the action.
        started: Number of episodes that began in it.
        ended: Number of episodes that ended in it.
        after: Number of transitions by next state after the action.
    """

    state: str
    action: str | None
    value: float | None
    tried: int
    met: int
    started: int
    ended: int
    after: Mapping[str, int]

    @property
    def end(self) -> float:
        """Share of visits to the state in which the episode ended in it."""
        return self.ended / self.met if self.met else 0.0

    def share(self, state: str) -> float:
        """Return Pr(state | this state, its action): the share of ``state`` among the next states.

        It is the share of all visits to this state. An episode that ended in it has no next state.
        """
        # The counts of next states are conditional on a departure. The factor relates them to all
        # visits.
        return (1 - self.end) * self.after.get(state, 0) / self.tried if self.tried else 0.0


class Arc(NamedTuple):
    """Transition that is likely enough to be drawn.

    Attributes:
        source: State before.
        target: State after.
        share: Probability under the policy.
        times: Number of observations.
    """

    source: str
    target: str
    share: float
    times: int


class PolicyTransitions(NamedTuple):
    """Transitions of a policy.

    Attributes:
        name: Name of the policy.
        program: Name of the program that it serves.
        members: Members behind the letters of a state, in order.
        programs: Members that are programs.
        above: Threshold for the share of drawn arcs; arcs of at most this share are left out.
        decisions: Drawn states, which drawn arcs reach from the initial states.
        arcs: Transitions between them.
        left_out: Number of other known states.
        rewarded: States in which, as far as known, every episode that ended there was rewarded.
    """

    name: str
    program: str
    members: tuple[str, ...]
    programs: frozenset[str]
    above: float
    decisions: tuple[Decision, ...]
    arcs: tuple[Arc, ...]
    left_out: int
    rewarded: frozenset[str]


# A policy document counts transitions n(s, a, s'), but neither initial nor final states. Over
# complete episodes, each state s satisfies the balance
#   departures(s) - arrivals(s) = begun(s) - ended(s).
# The sign of the difference shows which of both dominates, and the difference bounds it from below.
# The visits to s are max(departures, arrivals) if s is not both initial and final. Where this
# breaks: a state in which as many episodes begin as end counts as neither.
def decisions(policy: PolicyDocument) -> tuple[Decision, ...]:
    """Return all states that a policy decides, in its order, then states that only ended episodes.

    Initial and final states follow from the observed transitions. A state that was left more
    often than it was reached is initial; a state that was left less often is final.
    """
    came, left = _arrivals(policy), _departures(policy)
    states = dict.fromkeys((*policy.policy, *left, *came))
    return tuple(_decision(policy, state, came[state], left[state]) for state in states)


def require_legible(policy: PolicyDocument, file: Path) -> None:
    """Require that every state of a policy has a letter for each member.

    ``cb validate`` checks whether the members are those of its program.

    Raises:
        UsageError: A state has missing or unknown letters.
    """
    size = len(policy.predicates)
    for each in decisions(policy):
        if len(each.state) != size or not set(each.state) <= _LETTERS:
            members = ", ".join(policy.predicates) or "no members"
            raise UsageError(f"{file}: '{each.state}' is not a state of {members}; see cb validate")


def _arrivals(policy: PolicyDocument) -> Counter[str]:
    arrivals: Counter[str] = Counter()
    for actions in policy.transitions.values():
        for after in actions.values():
            arrivals.update(after)
    return arrivals


def _departures(policy: PolicyDocument) -> Counter[str]:
    return Counter(
        {
            state: sum(sum(after.values()) for after in actions.values())
            for state, actions in policy.transitions.items()
        }
    )


def _decision(policy: PolicyDocument, state: str, came: int, left: int) -> Decision:
    action = policy.policy.get(state)
    after = policy.transitions.get(state, {}).get(action or "", {})
    return Decision(
        state=state,
        action=action,
        value=policy.values.get(state, {}).get(action or ""),
        tried=sum(after.values()),
        met=max(came, left),
        started=max(0, left - came),
        ended=max(0, came - left),
        after=after,
    )


def policy_transitions(
    policy: PolicyDocument,
    above: float = ABOVE,
    every: bool = False,
    programs: Collection[str] = (),
    rewarded: Collection[str] | None = None,
) -> PolicyTransitions:
    """Return the transitions of a policy.

    Args:
        policy: Learned or written policy; the transitions of a written one are unknown.
        above: Threshold for drawn arcs: only larger shares are drawn, in [0, 1].
        every: True to draw also states that drawn arcs do not reach from the initial states.
        programs: Names of programs, to distinguish them from controllers among the members.
        rewarded: States in which every episode that ended there was rewarded. If ``None``, all
            final states, provided that the learning curve has no episode without reward.
    """
    known = {decision.state: decision for decision in decisions(policy)}
    leading = {state: _arcs(decision, above) for state, decision in known.items()}
    began = [state for state, decision in known.items() if decision.started]
    shown = _reached(began, leading)
    # A written policy has no transitions, and therefore no initial state: all of its states are
    # drawn.
    if every or not began:
        shown = list(dict.fromkeys((*shown, *known)))
    if rewarded is None:
        # The curve has the rewards of episodes, but not their final states. Only if all were
        # rewarded, each final state is known to be rewarding.
        always = policy.curve is not None and all(policy.curve.reward)
        rewarded = [decision.state for decision in known.values() if always and decision.ended]
    return PolicyTransitions(
        name=policy.name,
        program=policy.program,
        members=policy.predicates,
        programs=frozenset(programs).intersection(policy.predicates),
        above=above,
        decisions=tuple(known[state] for state in shown),
        arcs=tuple(arc for state in shown for arc in leading[state]),
        left_out=len(known) - len(shown),
        rewarded=frozenset(rewarded),
    )


def _arcs(decision: Decision, above: float) -> tuple[Arc, ...]:
    """Return the likely transitions out of a state, the likeliest first."""
    arcs = (
        Arc(decision.state, target, decision.share(target), times)
        for target, times in decision.after.items()
    )
    likely = (arc for arc in arcs if arc.share > above)
    return tuple(sorted(likely, key=lambda arc: (-arc.share, arc.target)))


def _reached(began: Sequence[str], leading: Mapping[str, Sequence[Arc]]) -> list[str]:
    """Return the states that arcs lead to, ordered by the number of arcs on the way."""
    reached = dict.fromkeys(began)
    waiting = list(began)
    while waiting:
        for arc in leading[waiting.pop(0)]:
            if arc.target not in reached:
                reached[arc.target] = None
                waiting.append(arc.target)
    return list(reached)
