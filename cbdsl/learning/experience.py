"""Experience of one finished episode."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from cbdsl.program.transition import Transition


@dataclass(frozen=True)
class Experience:
    """Finished episode, as learners see it.

    Attributes:
        context: of its stage.
        seed: of the episode.
        transitions: of the program that is learned, in their order.
        rewarded: by effector, the configuration in which it was when a controller that moves it
            earned the reward, rad.
        ticks: control ticks.
        sim_seconds: simulated time.
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
