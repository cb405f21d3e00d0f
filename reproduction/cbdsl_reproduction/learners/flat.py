"""Flat learner: each allocation an action, the context in the state (Section 5.3.1.1)."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from cbdsl import Transition
from cbdsl.api.learning import AccommodateConstants, Experience
from cbdsl.api.program import NO_FEATURES, CheckedProgram, Choice, Features, Policy
from cbdsl_reproduction.learners.context_letters import context_letters
from cbdsl_reproduction.learners.decisive import Decisive
from cbdsl_reproduction.learners.handedness_learner import EpisodePlan

if TYPE_CHECKING:
    import numpy as np


class Flat:
    """Q-learning over all allocated actions, in states that end with letters of the context.

    Args:
        program: Program with its allocations side by side.
        constants: Constants of the algorithm.
    """

    is_constrained = False

    def __init__(self, program: CheckedProgram, constants: AccommodateConstants) -> None:
        self._program = program
        places = {
            program.members.index(each.name): each.name
            for each in program.actions
            if each.program is not None
        }
        names = [action.name for action in program.actions]
        self.accommodate = Decisive(names, constants, places)
        self._before: Transition | None = None

    def begin(self) -> None:
        """Begin an episode (see ``HandednessLearner.begin``)."""
        self._before = None

    def plan(self, rng: np.random.Generator) -> EpisodePlan:
        """Return the program and policy of the episode (see ``HandednessLearner.plan``)."""
        return EpisodePlan(self._program, FlatPolicy(self.accommodate.policy(rng)))

    def see(self, transition: Transition) -> None:
        """Learn from the preceding transition, now that the context after it is known."""
        letters = context_letters(transition.features)
        self._flush(letters)
        self._before = replace(transition, state=transition.state + letters)

    def remember(self, experience: Experience) -> None:
        """Learn from the last transition, after which nothing was observed."""
        if self._before is not None:
            self._flush(context_letters(experience.transitions[-1].features))
        self.accommodate.remember(experience)

    def _flush(self, letters: str) -> None:
        if self._before is not None:
            after = self._before.next_state + letters
            self.accommodate.see(replace(self._before, next_state=after))
        self._before = None


class FlatPolicy(Policy):
    """Policy over states with context letters.

    Args:
        policy: Policy that chooses by the extended states.
    """

    allocates = True

    def __init__(self, policy: Policy) -> None:
        self._policy = policy

    def choose(self, state: str, *, changed: bool, features: Features = NO_FEATURES) -> Choice:
        """Return the next action (see ``Policy.choose``)."""
        return self._policy.choose(state + context_letters(features), changed=changed)
