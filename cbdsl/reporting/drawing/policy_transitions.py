"""The states of a policy, their actions, and the transitions observed between them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from cbdsl.documents.policy import PolicyDocument
from cbdsl.errors.errors import UsageError
from cbdsl.types.state import ANY, PREDICATES

#: Arcs of a larger share are drawn, as in the figures of Chapter 4.
ABOVE = 0.2

_LETTERS = frozenset(PREDICATES + ANY)


class Decision(NamedTuple):
    """The action of a policy in a state, and what was observed of it.

    Attributes:
        state: one letter per member; in written policies also ``*``, which stands for any.
        action: what is done, or ``None`` where the policy has nothing for this state.
        value: discounted reward to expect of it, or ``None`` where nothing was learned.
        tried: how often it was tried.
        met: how often the state was met, whatever was done in it.
        started: how many episodes began in it.
        ended: how many episodes ended in it.
        after: how often which state followed the action.
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
        """Share of the times that the state was met in which the episode ended in it."""
        return self.ended / self.met if self.met else 0.0

    def share(self, state: str) -> float:
        """Pr(state | this state, its action): the share of ``state`` among what follows.

        It is that of all times that this state was met. An episode that ended in it went nowhere.
        """
        return (1 - self.end) * self.after.get(state, 0) / self.tried if self.tried else 0.0


class Arc(NamedTuple):
    """A transition that is likely enough to be drawn.

    Attributes:
        source: the state before.
        target: the state after.
        share: its probability under the policy.
        times: how often it was observed.
    """

    source: str
    target: str
    share: float
    times: int


class PolicyTransitions(NamedTuple):
    """A policy.

    Attributes:
        name: of the policy.
        program: that it serves.
        members: what a state has a letter for, in order.
        programs: those of the members that are programs.
        above: arcs of at most this share are left out.
        decisions: what is drawn: the states that drawn arcs lead to from where episodes began.
        arcs: the transitions between them.
        left_out: how many other states are known.
        rewarded: the states in which every episode that ended there was rewarded, as far as known.
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


def decisions(policy: PolicyDocument) -> tuple[Decision, ...]:
    """All states that a policy decides, as it orders them, then those that only ended episodes.

    Where episodes began and ended follows from the observed transitions: a state that was left
    more often than it was come to is where they began, one that was left less often where they
    ended.
    """
    came, left = _arrivals(policy), _departures(policy)
    states = dict.fromkeys((*policy.policy, *left, *came))
    return tuple(_decision(policy, state, came[state], left[state]) for state in states)


def require_legible(policy: PolicyDocument, file: Path) -> None:
    """Make sure that every state of a policy has a letter for each member.

    Whether they are those of its program is for ``cb validate`` to say.

    Raises:
        UsageError: one has not.
    """
    size = len(policy.predicates)
    for each in decisions(policy):
        if len(each.state) != size or not set(each.state) <= _LETTERS:
            members = ", ".join(policy.predicates) or "no members"
            raise UsageError(f"{file}: '{each.state}' is no state of {members}; see cb validate")


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
    """The transitions of a policy.

    Args:
        policy: learned, or written: then nothing is known of what follows a state.
        above: arcs of a larger share are drawn, in [0, 1].
        every: draw also states that drawn arcs do not lead to from where episodes began.
        programs: names of programs, to tell them from controllers among the members.
        rewarded: the states in which every episode that ended there was rewarded; without it, all
            of them where the learning curve has no episode without reward.
    """
    known = {decision.state: decision for decision in decisions(policy)}
    leading = {state: _arcs(decision, above) for state, decision in known.items()}
    began = [state for state, decision in known.items() if decision.started]
    shown = _reached(began, leading)
    if every or not began:
        shown = list(dict.fromkeys((*shown, *known)))
    if rewarded is None:
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
    """The likely transitions out of a state, the likeliest first."""
    arcs = (
        Arc(decision.state, target, decision.share(target), times)
        for target, times in decision.after.items()
    )
    likely = (arc for arc in arcs if arc.share > above)
    return tuple(sorted(likely, key=lambda arc: (-arc.share, arc.target)))


def _reached(began: Sequence[str], leading: Mapping[str, Sequence[Arc]]) -> list[str]:
    """The states that arcs lead to, those that fewer arcs lead to first."""
    reached = dict.fromkeys(began)
    waiting = list(began)
    while waiting:
        for arc in leading[waiting.pop(0)]:
            if arc.target not in reached:
                reached[arc.target] = None
                waiting.append(arc.target)
    return list(reached)
