"""Experience of one finished episode."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from cbdsl.program.transition import Transition


@dataclass(frozen=True)
class Experience:
    """Finished episode in the form that learners use.

    Attributes:
        context: Name of the stage's context.
        seed: Random seed of the episode.
        transitions: Transitions of the learned program, in order.
        rewarded: Configuration of each effector when a controller that moves it earned the reward,
            rad.
        ticks: Number of control ticks.
        sim_seconds: Simulated time, s.
    """

    context: str
    seed: int
    transitions: tuple[Transition, ...]
    rewarded: Mapping[str, tuple[float, ...]]
    ticks: int
    sim_seconds: float

    @property
    def reward(self) -> int:
        """Sum of the rewards of its transitions."""
        return sum(transition.reward for transition in self.transitions)
