"""Staged learner: first what to do, then with what (Section 5.3.1.1)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.learning.assimilate import AssimilateConstants
from cbdsl.learning.concurrent import Concurrent
from cbdsl.learning.constants import AccommodateConstants
from cbdsl.learning.experience import Experience
from cbdsl.learning.handedness_learner import EpisodePlan
from cbdsl.program.checked import CheckedProgram

if TYPE_CHECKING:
    import numpy as np


class Staged(Concurrent):
    """ACCOMMODATE with the program's own arm, then ASSIMILATE with all that it can be allocated.

    From the second stage on the abstract actions are those that are worth most. What they are worth
    is still learned, without exploring: of two that have earned the same with one arm, one may not
    do with others.

    Args:
        schema: the program with all its allocations.
        own: the program with its own.
        constants: of the choice of abstract actions.
        allocating: of the choice of allocations.
        episodes: of the first stage.
    """

    def __init__(
        self,
        schema: CheckedProgram,
        own: CheckedProgram,
        constants: AccommodateConstants,
        allocating: AssimilateConstants,
        episodes: int,
    ) -> None:
        first = constants.model_copy(update={"exploring_episodes": episodes})
        super().__init__(schema, first, allocating)
        self._own, self._left = own, episodes

    @property
    def is_constrained(self) -> bool:  # type: ignore[override]
        """See ``HandednessLearner.is_constrained``."""
        return self._left > 0

    def plan(self, rng: np.random.Generator) -> EpisodePlan:
        """See ``HandednessLearner.plan``."""
        if self.is_constrained:
            return EpisodePlan(self._own, self.accommodate.policy(rng))
        return super().plan(rng)

    def remember(self, experience: Experience) -> None:
        """See ``HandednessLearner.remember``."""
        if self.is_constrained:
            self.accommodate.remember(experience)
            self._left -= 1
        else:
            super().remember(experience)
