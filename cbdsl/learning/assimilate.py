"""ASSIMILATE: the resources that an action needs in each context (Algorithm 2)."""

# Model: whether an allocation of resources is rewarded depends on a few features of the context f,
# such as the object's position. Two decision trees are grown from the contexts of all episodes:
#     psi(f)             allocation with the highest probability of reward (Eq 5.3 and 5.4)
#     Pr(reward | pi, f) probability that the policy pi is rewarded with that allocation
# A leaf with h rewards of n trials estimates (h + 1) / (n + 2), Laplace's rule of succession. While
# it explores, the learner draws each allocation with the probability that it is the best one
# (Thompson sampling from the Beta distributions of the leaf). An episode tries several allocations
# in turn, and each attempt is one sample of its allocation. A context without reward counts for the
# tree of reward only if the preferred allocation was tried.
# Assumptions: attempts of one episode share their context, although an attempt may displace the
# object; ``blames_first`` drops later attempts. Differences below _RESOLUTION are noise.
# Source: Algorithm 2, Section 5.3.

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Annotated, Any

import numpy as np

from cbdsl.documents.document import Document, PositiveCount, Section, quantity
from cbdsl.documents.model import Gaussian, Kernel
from cbdsl.documents.program import Use
from cbdsl.documents.schema import (
    AbstractAction,
    ChoiceQuestion,
    Probability,
    RewardQuestion,
    SchemaDocument,
)
from cbdsl.learning.accommodate import RewardedConfigurations
from cbdsl.learning.allocation_tree import Tally, TriedContext, grow_tallies, rankings
from cbdsl.learning.always import Always
from cbdsl.learning.constants import DensityConstants
from cbdsl.learning.experience import Experience
from cbdsl.learning.knowledge_documents import curve_of, learned_by, model_documents
from cbdsl.learning.learner import TrialSummary
from cbdsl.learning.tree_growth import Outcomes, grow
from cbdsl.program.attempts import attempts
from cbdsl.program.checked import CheckedProgram, PriorLook
from cbdsl.program.schema import Features, Rank, Ranking, Schema
from cbdsl.program.transition import Transition
from cbdsl.runtime.policies.policy import Policy
from cbdsl.runtime.policies.schema_policy import SchemaPolicy
from cbdsl.types.decision_tree import Leaf, Tree, decide

# Resolution of perceived positions, velocities and volumes, by unit. Finer differences are noise,
# from which a tree would derive questions.
_RESOLUTION = {"m": 0.01, "m/s": 0.02, "m^3": 0.001}
# A context that is predicted to be unrewarded is never tried again, so that a false alarm is not
# corrected. An unrewarded attempt is. This share of a gap without samples counts as worth an
# attempt.
_TRUST = 0.7


class AssimilateConstants(Section):
    """Constants of Algorithm 2, line 3, and of the trees that it grows."""

    draws: bool = True
    """Whether allocations are chosen as often as each is likely to be the best."""
    epsilon: Annotated[float, quantity(ge=0, le=1)] = 0.2
    """Share of allocations chosen at random where they are not drawn."""
    blames_first: bool = False
    """True if the first attempt of an episode without reward counts as failed."""
    least_samples: PositiveCount = 2
    """Fewest contexts in a leaf of the tree of reward."""
    least_attempts: PositiveCount = 3
    """Fewest contexts in a leaf of the tree of allocations."""
    least_reward: Probability = 0.5
    """Probability of reward below which the schema is undefined."""


class Assimilate:
    """Decision trees of which allocation leads to reward, and of where any does.

    Args:
        actions: Names of the actions.
        constants: Constants of the algorithm.
        programs: Actions that are programs, by the place of their predicates in a state.
    """

    Constants = AssimilateConstants

    def __init__(
        self,
        actions: Sequence[str],
        constants: AssimilateConstants,
        programs: Mapping[int, str] = MappingProxyType({}),
    ) -> None:
        self._first, self._constants = actions[0] if actions else "", constants
        self._program: CheckedProgram | None = None
        self._contexts: list[TriedContext] = []

    def adopt(self, program: CheckedProgram) -> None:
        """Set the schema whose allocations are learned."""
        assert program.schema is not None
        self._program = program

    def see(self, transition: Transition) -> None:
        """Ignore the transition, because an attempt may be rewarded until the episode ends."""

    def remember(self, experience: Experience) -> None:
        """Learn from the attempts of a finished episode (lines 18 and 25)."""
        schema = self._program.schema if self._program is not None else None
        if schema is None:
            return
        made = [
            each
            for each in attempts(experience.transitions, schema.worth)
            if each.features.keys() >= set(schema.components)
        ]
        if made:
            outcomes = {each.allocation: each.rewarded for each in made}
            self._contexts.append(TriedContext(_distinct(made[0].features, schema), outcomes))

    @property
    def contexts(self) -> tuple[TriedContext, ...]:
        """Contexts with trials, by episode."""
        return tuple(self._contexts)

    def recall(self, contexts: Iterable[TriedContext]) -> None:
        """Add contexts of earlier trials, instead of running them again."""
        self._contexts.extend(contexts)

    def policy(self, rng: np.random.Generator) -> Policy:
        """Return the declarative policy with exploring allocations, from present knowledge."""
        if self._program is None or self._program.schema is None:
            return Always(self._first)
        return SchemaPolicy(self._program, self.ranking(rng), gives_up=False)

    def ranking(self, rng: np.random.Generator) -> Rank:
        """Return an exploring choice of allocations, from the present knowledge (Eq 5.4)."""
        tallies, names, constants = self._tallies(), self._names, self._constants

        def rank(features: Features) -> Ranking:
            tally = decide(tallies, features)
            if tally is None or not self._contexts:
                return tuple(names[i] for i in rng.permutation(len(names)))
            if constants.draws:
                return tally.drawn(names, rng)
            if rng.random() < constants.epsilon:
                return tuple(names[i] for i in rng.permutation(len(names)))
            return tuple(dict.fromkeys((*tally.ranking(names), *names)))

        return rank

    @property
    def _names(self) -> tuple[str, ...]:
        schema = self._program.schema if self._program is not None else None
        return tuple(schema.allocations) if schema is not None else ()

    @property
    def _resolutions(self) -> Mapping[str, float]:
        """Insignificant differences of features, by component."""
        assert self._program is not None
        assert self._program.schema is not None
        schema = self._program.schema
        units = {name: _unit(name, schema) for name in schema.components}
        return {name: _RESOLUTION[unit] for name, unit in units.items() if unit in _RESOLUTION}

    def _tallies(self) -> Tree[Tally]:
        contexts = self._contexts
        if self._constants.blames_first:
            contexts = [each if each.rewarded else each.first_alone() for each in contexts]
        least = self._constants.least_attempts
        return grow_tallies(contexts, self._names, least, self._resolutions)

    def choice(self) -> Tree[Ranking]:
        """Return the tree of allocations that were rewarded (Eq 5.4)."""
        return rankings(self._tallies(), self._names)

    def reward(self) -> Tree[float]:
        """Return the tree of Pr(reward | pi, f), by Laplace's rule of succession.

        The policy includes its choice of allocations. An unrewarded episode in which the preferred
        allocation was not tried, as happens during exploration, is no evidence against reward.
        """
        choice = self.choice()
        contexts = [each for each in self._contexts if each.rewarded or self._tried(each, choice)]
        rewarded = np.array([[each.rewarded] for each in contexts], dtype=float)
        rewarded = rewarded.reshape(len(contexts), 1)

        def likely(rows: list[int]) -> float:
            return round((float(rewarded[rows].sum()) + 1) / (len(rows) + 2), 3)

        samples = [each.features for each in contexts]
        outcomes, least = Outcomes(rewarded, 1.0 - rewarded), self._constants.least_samples
        # Each feature is equally likely to matter.
        needed = math.log(max(1, len(next(iter(samples), ()))))
        return grow(samples, outcomes, likely, least, self._resolutions, _TRUST, needed)

    def _ranges(self) -> dict[str, tuple[float, float]]:
        """Return the least and largest value of each component of the features."""
        assert self._program is not None
        assert self._program.schema is not None
        ranges = {}
        for name in self._program.schema.components if self._contexts else ():
            values = [each.features[name] for each in self._contexts]
            # Features are rounded, so that each stands for values on both sides of it.
            about = self._resolutions.get(name, 0.0) / 2
            ranges[name] = round(min(values) - about, 4), round(max(values) + about, 4)
        return ranges

    def _tried(self, context: TriedContext, choice: Tree[Ranking]) -> bool:
        """Return whether a context's preferred allocation was tried (as the first, if blamed)."""
        made = context.first_alone() if self._constants.blames_first else context
        first = (decide(choice, context.features) or ())[:1]
        return made.outcomes.keys() >= {*first}

    def greedy(self) -> dict[str, str]:
        """Return the declarative policy, which is not learned."""
        return dict(self._program.policy) if self._program else {}

    def densities(self) -> dict[str, Kernel | Gaussian]:
        """Return no densities, because internal models are not learned."""
        return {}

    def documents(self, summary: TrialSummary) -> list[Document]:
        """Return the learned schema with its learning curve and provenance."""
        learned = {
            "description": learned_by(summary),
            "curve": curve_of(summary.experiences),
            "provenance": summary.provenance,
        }
        return [self.document(summary.name, summary.program).model_copy(update=learned)]

    def document(self, name: str, program: CheckedProgram) -> SchemaDocument:
        """Return a schema of the present knowledge, without curve and provenance."""
        assert self._program is not None
        assert self._program.schema is not None
        schema, parameters = self._program.schema, program.parameters
        exchanged = {key for each in schema.allocations.values() for key in each}
        kept = {key: value for key, value in parameters.items() if key not in exchanged}
        units = {name: _unit(name, schema) for name in schema.components}
        return SchemaDocument(
            cbdsl=1,
            kind="schema",
            name=name,
            program=program.name,
            policy=schema.policy,
            actions=_abstract_actions(self._program),
            features={n: _text(r.name, kept) for n, r in schema.features.items()},
            look={name: _use(look, parameters) for name, look in self._program.looks.items()},
            allocations={name: dict(each) for name, each in schema.allocations.items()},
            choose=_written(self.choice(), units, ChoiceQuestion, _answer),
            otherwise=tuple(schema.allocations),
            reward=_written(self.reward(), units, RewardQuestion, float),
            tried=self._ranges(),
            least_reward=self._constants.least_reward,
        )


class TransferConstants(DensityConstants, AssimilateConstants):
    """Constants of Algorithm 2, and of the densities that are learned beside it."""


# TRANSFER (Section 8.2). The declarative part of a schema, its policy over abstract actions, names
# no robot (Section 5.3). It is kept. The procedural part is about one body: which of its resources
# to use in which context, and where its effectors are rewarded. It is learned from the start.
class Transfer(Assimilate):
    """Allocations and internal models of a robot for a policy that another robot learned.

    Args:
        actions: Names of the actions.
        constants: Constants of the algorithm.
        programs: Actions that are programs, by the place of their predicates in a state.
    """

    Constants = TransferConstants

    def __init__(
        self,
        actions: Sequence[str],
        constants: TransferConstants,
        programs: Mapping[int, str] = MappingProxyType({}),
    ) -> None:
        super().__init__(actions, constants, programs)
        self._rewarded = RewardedConfigurations(constants)

    def remember(self, experience: Experience) -> None:
        """Learn from the attempts and the rewarded configurations of a finished episode."""
        super().remember(experience)
        self._rewarded.add(experience)

    def densities(self) -> dict[str, Kernel | Gaussian]:
        """Return densities of the rewarded configurations, by effector."""
        return self._rewarded.densities()

    def documents(self, summary: TrialSummary) -> list[Document]:
        """Return the internal models, and the schema that draws from them."""
        (schema,) = super().documents(summary)
        models = {model: f"{summary.name}_{each}" for model, each in summary.models.items()}
        updated = schema.model_copy(update={"models": models})
        return [*model_documents(summary, self.densities()), updated]


def _distinct(features: Features, schema: Schema) -> Features:
    """Round the features to their resolution."""
    return {
        name: round(value / _RESOLUTION[unit]) * _RESOLUTION[unit]
        if (unit := _unit(name, schema)) in _RESOLUTION
        else value
        for name, value in features.items()
    }


def _unit(component: str, schema: Schema) -> str:
    return schema.features[component.partition(".")[0]].type.unit


def _text(name: str, parameters: Mapping[str, str]) -> str:
    """Replace values of parameters in a resource's name by references to the parameters."""
    by_value = {value: f"${key}" for key, value in parameters.items()}
    return ".".join(by_value.get(part, part) for part in name.split("."))


def _use(look: PriorLook, parameters: Mapping[str, str]) -> Use:
    """Return the document section of the program that searches for a feature."""
    values = {key: _text(value, parameters) for key, value in look.values.items()}
    written = {"program": look.name, "policy": look.policy, "with": values}
    return Use.model_validate({key: value for key, value in written.items() if value})


def _abstract_actions(program: CheckedProgram) -> dict[str, AbstractAction]:
    leads = {name: primitive.lead for name, primitive in program.primitives.items()}
    return {
        name: AbstractAction.model_validate(
            {
                "potential": lead.potential,
                "in": lead.feedback.type.name,
                "out": lead.effector.type.name,
            }
        )
        for name, lead in leads.items()
    }


def _answer(ranking: Ranking) -> str | Ranking:
    return ranking[0] if len(ranking) == 1 else ranking


def _written(
    tree: Tree[Any],
    units: Mapping[str, str],
    question: type[ChoiceQuestion | RewardQuestion],
    answer: Callable[[Any], Any],
) -> Any:
    """Return a tree in the form of documents.

    Args:
        tree: Grown tree.
        units: Units by component of the features.
        question: Section type of a question.
        answer: Function that converts the answer of a leaf.
    """
    if isinstance(tree, Leaf):
        return answer(tree.answer)
    return question.model_validate(
        {
            "if": f"{tree.feature} > {tree.threshold:g} {units[tree.feature]}".rstrip(),
            "then": _written(tree.above, units, question, answer),
            "else": _written(tree.below, units, question, answer),
        }
    )
