"""Learners of handedness: which action, with which arm (Section 5.3.1.1)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

from cbdsl.learning.experience import Experience
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.transition import Transition
from cbdsl.types.policy import Policy

if TYPE_CHECKING:
    import numpy as np


class EpisodePlan(NamedTuple):
    """A program with the policy that chooses its actions."""

    program: CheckedProgram
    policy: Policy


class HandednessLearner(Protocol):
    """Learner that chooses actions and their resources; equal experience, equal knowledge."""

    @property
    def is_constrained(self) -> bool:
        """Whether the next episode belongs to a first stage with the program's own arm."""
        ...

    def begin(self) -> None:
        """Begin an episode with what is known now."""
        ...

    def plan(self, rng: np.random.Generator) -> EpisodePlan:
        """Program and policy of the episode that was begun; it may explore."""
        ...

    def see(self, transition: Transition) -> None:
        """Take in one transition, before the next action is chosen."""
        ...

    def remember(self, experience: Experience) -> None:
        """Take in a finished episode, besides its transitions."""
        ...


def replay(learner: HandednessLearner, experience: Experience) -> None:
    """Have a learner take in an episode that was finished before."""
    learner.begin()
    for transition in experience.transitions:
        learner.see(transition)
    learner.remember(experience)
