"""Synthetic experiences."""

from __future__ import annotations

from cbdsl.learning.experience import Experience
from cbdsl.program.transition import Transition


def experience(*steps: tuple[str, str, str], reward: int = 0, context: str = "some") -> Experience:
    """Return an episode with the given arcs, rewarded at its end or not."""
    transitions = tuple(
        Transition(
            program="some",
            depth=0,
            time=float(number),
            state=state,
            action=action,
            next_state=after,
            ticks=1,
            reward=reward if number == len(steps) - 1 else 0,
            rewarding=(),
        )
        for number, (state, action, after) in enumerate(steps)
    )
    return Experience(context, 0, transitions, {}, len(steps), float(len(steps)))
