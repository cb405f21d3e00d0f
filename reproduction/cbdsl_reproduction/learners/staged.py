"""Staged learner: first the actions, then their resources (Section 5.3.1.1)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.api.learning import AccommodateConstants, AssimilateConstants, Experience
from cbdsl.api.program import CheckedProgram
from cbdsl_reproduction.learners.concurrent import Concurrent
from cbdsl_reproduction.learners.handedness_learner import EpisodePlan

if TYPE_CHECKING:
    import numpy as np


class Staged(Concurrent):
    """ACCOMMODATE with the program's own arm, then ASSIMILATE with all allocations.

    From the second stage on, the abstract actions are greedy. Their values are still learned,
    without exploration: two actions of equal value with one arm may differ with others.

    Args:
        schema: Program with all its allocations.
        own: Program with its own allocation.
        constants: Constants of the choice of abstract actions.
        allocating: Constants of the choice of allocations.
        episodes: Number of episodes of the first stage.
    """

    def __init__(
        self,
        schema: CheckedProgram,
        own: CheckedProgram,
        constants: AccommodateConstants,
        allocating: AssimilateConstants,
        episodes: int,
    ) -> None:
        # After this number of episodes, the abstract actions are greedy.
        first = constants.model_copy(update={"exploring_episodes": episodes})
        super().__init__(schema, first, allocating)
        self._own, self._left = own, episodes

    @property
    def is_constrained(self) -> bool:  # type: ignore[override]
        """Whether the first stage goes on (see ``HandednessLearner.is_constrained``)."""
        return self._left > 0

    def plan(self, rng: np.random.Generator) -> EpisodePlan:
        """Return the program and policy of the episode (see ``HandednessLearner.plan``)."""
        if self.is_constrained:
            return EpisodePlan(self._own, self.accommodate.policy(rng))
        return super().plan(rng)

    def remember(self, experience: Experience) -> None:
        """Learn from a finished episode (see ``HandednessLearner.remember``)."""
        if self.is_constrained:
            self.accommodate.remember(experience)
            self._left -= 1
        else:
            super().remember(experience)
