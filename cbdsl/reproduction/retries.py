"""Retries: a reach that has found nothing, made again with other resources (Figure 5.9)."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace

from cbdsl.learning.experience import Experience
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.transition import Transition
from cbdsl.reproduction.claim import above
from cbdsl.reproduction.diagram import Diagram, graph_of
from cbdsl.reproduction.percentage import clustered_percentage, percentage
from cbdsl.reproduction.quantity import Quantity

# The reach at rest and nothing felt; on its way again.
_IN_VAIN, _AGAIN = "X1-", "X0-"

Episodes = Sequence[Experience]


def retries(experience: Experience) -> Iterator[Transition]:
    """Transitions from X1- back to X0- under another allocation than that which led there."""
    for before, after in itertools.pairwise(experience.transitions):
        is_back = (after.state, after.next_state) == (_IN_VAIN, _AGAIN)
        if is_back and after.allocation != before.allocation:
            yield after


def retry_quantities(trials: Sequence[Episodes]) -> Iterator[Quantity]:
    """In how many trials there are retries, and how many of their episodes are rewarded.

    Args:
        trials: the episodes of the second stage of each.
    """
    with_any = [any(any(True for _ in retries(each)) for each in trial) for trial in trials]
    name = f"Figure 5.9: trials that learn the retry {_IN_VAIN} → {_AGAIN}"
    yield percentage(name, "drawn", sum(with_any), len(trials), above(50))
    rewarded = [
        [each.reward > 0 for each in trial if next(retries(each), None) is not None]
        for trial in trials
    ]
    yield clustered_percentage(
        "Figure 5.9: episodes with a retry that come to their reward",
        "eventually",
        [sum(own) for own in rewarded],
        [len(own) for own in rewarded],
        above(50),
        of="episodes",
    )


def retry_diagram(name: str, program: CheckedProgram, trials: Sequence[Episodes]) -> Diagram:
    """Diagram of the second stage, by the abstract action that is chosen most in each state.

    Args:
        name: of the experiment.
        program: whose abstract actions they are.
        trials: the episodes of the second stage of each.
    """
    episodes = [_abstract(each) for trial in trials for each in trial]
    chosen = Counter((t.state, t.action) for each in episodes for t in each.transitions)
    most: dict[str, str] = {}
    for (state, action), _ in chosen.most_common():
        most.setdefault(state, action)
    kept = [
        replace(each, transitions=some)
        for each in episodes
        if (some := tuple(t for t in each.transitions if most[t.state] == t.action))
    ]
    graph = graph_of("staged", program, kept)
    title = f"REACHTOUCH in the second stage, {len(trials)} trials, the most frequent actions"
    return Diagram(f"{name}-reachtouch", title, graph)


def _abstract(experience: Experience) -> Experience:
    """An episode without what its actions were allocated with."""
    transitions = (
        replace(each, action=each.action.removesuffix(f" with {each.allocation}"))
        for each in experience.transitions
    )
    return replace(experience, transitions=tuple(transitions))
