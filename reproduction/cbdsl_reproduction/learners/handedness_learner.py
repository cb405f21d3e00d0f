"""Learners of handedness: the action and the arm to use (Section 5.3.1.1)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

from cbdsl import Transition
from cbdsl.api.learning import Experience
from cbdsl.api.program import CheckedProgram, Policy

if TYPE_CHECKING:
    import numpy as np


class EpisodePlan(NamedTuple):
    """Program with the policy that chooses its actions."""

    program: CheckedProgram
    policy: Policy


class HandednessLearner(Protocol):
    """Learner of actions and their resources; the same experience gives the same knowledge."""

    @property
    def is_constrained(self) -> bool:
        """Whether the next episode belongs to a first stage with the program's own arm."""
        ...

    def begin(self) -> None:
        """Begin an episode with the present knowledge."""
        ...

    def plan(self, rng: np.random.Generator) -> EpisodePlan:
        """Return the program and the possibly exploring policy of the current episode."""
        ...

    def see(self, transition: Transition) -> None:
        """Learn from one transition, before the next action is chosen."""
        ...

    def remember(self, experience: Experience) -> None:
        """Learn from a finished episode, in addition to its transitions."""
        ...


def replay(learner: HandednessLearner, experience: Experience) -> None:
    """Let a learner learn from an earlier episode."""
    learner.begin()
    for transition in experience.transitions:
        learner.see(transition)
    learner.remember(experience)
