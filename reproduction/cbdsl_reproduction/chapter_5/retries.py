"""Retries: a reach without contact, repeated with other resources (Figure 5.9)."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace

from cbdsl import Transition
from cbdsl.api.learning import Experience
from cbdsl.api.program import CheckedProgram
from cbdsl_reproduction.claim import Claim
from cbdsl_reproduction.diagram import Diagram, graph_of
from cbdsl_reproduction.percentage import clustered_percentage, percentage
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import above

# States of a reach at rest without contact, and of a renewed reach.
_IN_VAIN, _AGAIN = "X1-", "X0-"
_PLACE = "Section 5.3.1.2, Figure 5.9"
_LEARNS = Claim(
    _PLACE,
    f"Figure 5.9: trials that learn the retry {_IN_VAIN} → {_AGAIN}",
    "%",
    "drawn",
    above(50),
)
_EARNS = Claim(
    _PLACE,
    "Figure 5.9: episodes with a retry that come to their reward",
    "%",
    "eventually",
    above(50),
)
RETRY_CLAIMS = (_LEARNS, _EARNS)

Episodes = Sequence[Experience]


def retries(experience: Experience) -> Iterator[Transition]:
    """Yield transitions from X1- back to X0- under another allocation than before."""
    for before, after in itertools.pairwise(experience.transitions):
        is_back = (after.state, after.next_state) == (_IN_VAIN, _AGAIN)
        if is_back and after.allocation != before.allocation:
            yield after


def retry_quantities(trials: Sequence[Episodes]) -> Iterator[Quantity]:
    """Yield the share of trials with retries, and the share of rewarded episodes with retries.

    Args:
        trials: Episodes of the second stage of each trial.
    """
    with_any = [any(any(True for _ in retries(each)) for each in trial) for trial in trials]
    yield percentage(_LEARNS, sum(with_any), len(trials))
    rewarded = [
        [each.reward > 0 for each in trial if next(retries(each), None) is not None]
        for trial in trials
    ]
    # Episodes of one trial follow the same policy and the same trees, and are not independent.
    yield clustered_percentage(
        _EARNS,
        [sum(own) for own in rewarded],
        [len(own) for own in rewarded],
        of="episodes",
    )


def retry_diagram(name: str, program: CheckedProgram, trials: Sequence[Episodes]) -> Diagram:
    """Return the diagram of the second stage for the most frequent abstract action of each state.

    Args:
        name: Name of the experiment.
        program: Program with the abstract actions.
        trials: Episodes of the second stage of each trial.
    """
    episodes = [_abstract(each) for trial in trials for each in trial]
    chosen = Counter((t.state, t.action) for each in episodes for t in each.transitions)
    most: dict[str, str] = {}
    # Pairs come by descending frequency, so that the
    # first action of a state is its most frequent one.
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
    """Return an episode without the allocations of its actions."""
    transitions = (
        replace(each, action=each.action.removesuffix(f" with {each.allocation}"))
        for each in experience.transitions
    )
    return replace(experience, transitions=tuple(transitions))
