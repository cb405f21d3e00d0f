"""Concurrent learner: abstract actions and their resources simultaneously (Section 5.3.1.1)."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from cbdsl import Transition
from cbdsl.api.learning import AccommodateConstants, Assimilate, AssimilateConstants, Experience
from cbdsl.api.program import CheckedProgram, SchemaPolicy, state_values
from cbdsl_reproduction.learners.decisive import Decisive
from cbdsl_reproduction.learners.handedness_learner import EpisodePlan

if TYPE_CHECKING:
    import numpy as np


class Concurrent:
    """Q-learning over abstract actions, and ASSIMILATE over their allocations.

    Args:
        schema: Program with all its allocations.
        constants: Constants of the choice of abstract actions.
        allocating: Constants of the choice of allocations.

    Attributes:
        accommodate, assimilate: Learners of the actions and of the allocations.
    """

    is_constrained = False

    def __init__(
        self,
        schema: CheckedProgram,
        constants: AccommodateConstants,
        allocating: AssimilateConstants,
    ) -> None:
        self._schema = schema
        self._abstract = {action.name: action.abstract for action in schema.actions}
        names = tuple(dict.fromkeys(self._abstract.values()))
        programs = {
            schema.members.index(each.part): each.part
            for each in schema.actions
            if each.program is not None
        }
        self.accommodate = Decisive(names, constants, programs)
        self.assimilate = Assimilate(names, allocating)

    def begin(self) -> None:
        """Update the state values that distinguish progress from failure."""
        assert self._schema.schema is not None
        greedy, counts = self.accommodate.greedy(), dict(self.accommodate.counts.items())
        # The values of the abstract actions change in each episode, and with them the worth of
        # states.
        worth = state_values(greedy, counts) if greedy else {}
        schema = self._schema.schema._replace(worth=worth)
        self._known = self._schema._replace(policy=greedy, schema=schema)
        self.assimilate.adopt(self._known)

    def plan(self, rng: np.random.Generator) -> EpisodePlan:
        """Return the program and policy of the episode (see ``HandednessLearner.plan``)."""
        policy = SchemaPolicy(
            self._known,
            self.assimilate.ranking(rng),
            gives_up=False,
            declarative=self.accommodate.policy(rng),
            persists=True,
        )
        return EpisodePlan(self._known, policy)

    def see(self, transition: Transition) -> None:
        """Learn from the abstract action of a transition."""
        action = self._abstract.get(transition.action, transition.action)
        self.accommodate.see(replace(transition, action=action))

    def remember(self, experience: Experience) -> None:
        """Learn from a finished episode (see ``HandednessLearner.remember``)."""
        self.accommodate.remember(experience)
        self.assimilate.remember(experience)
