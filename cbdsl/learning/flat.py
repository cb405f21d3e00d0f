"""Flat learner: every allocation an action, the context in the state (Section 5.3.1.1)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from cbdsl.learning.constants import AccommodateConstants
from cbdsl.learning.context_letters import context_letters
from cbdsl.learning.decisive import Decisive
from cbdsl.learning.experience import Experience
from cbdsl.learning.handedness_learner import EpisodePlan
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.transition import Transition
from cbdsl.types.policy import Policy

if TYPE_CHECKING:
    import numpy as np


class Flat:
    """Q-learning over all allocated actions, in states that end with letters of the context.

    Args:
        program: with its allocations side by side.
        constants: of the algorithm.
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
        """See ``HandednessLearner.begin``."""
        self._before = None

    def plan(self, rng: np.random.Generator) -> EpisodePlan:
        """See ``HandednessLearner.plan``."""
        return EpisodePlan(self._program, FlatPolicy(self.accommodate.policy(rng)))

    def see(self, transition: Transition) -> None:
        """Take in the transition before, of which only now the context is known that it led to."""
        letters = context_letters(transition.features)
        self._flush(letters)
        self._before = replace(transition, state=transition.state + letters)

    def remember(self, experience: Experience) -> None:
        """Take in the last transition, after which nothing was looked at."""
        if self._before is not None:
            self._flush(context_letters(experience.transitions[-1].features))
        self.accommodate.remember(experience)

    def _flush(self, letters: str) -> None:
        if self._before is not None:
            after = self._before.next_state + letters
            self.accommodate.see(replace(self._before, next_state=after))
        self._before = None


class FlatPolicy:
    """A policy of states with letters of the context.

    Args:
        policy: chooses by them.

    Attributes:
        reason, withdraws: see ``ContextPolicy``.
    """

    reason, withdraws = "", False

    def __init__(self, policy: Policy) -> None:
        self._policy = policy
        self.begin(dict)

    def begin(self, read: Callable[[], Mapping[str, float]]) -> None:
        """See ``ContextPolicy.begin``."""
        self._read = read

    def choose(self, state: str, *, changed: bool) -> str | None:
        """See ``ContextPolicy.choose``."""
        return self._policy.choose(state + context_letters(self._read()), changed=changed)
