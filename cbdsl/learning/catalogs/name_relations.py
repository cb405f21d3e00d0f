"""NAME_RELATIONS: a teacher's names of contacts, by impedance (Section 7.2.3)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.document import Document, PositiveCount, Section
from cbdsl.documents.model import Gaussian, Kernel
from cbdsl.documents.relations import RelationQuestion, RelationsDocument, RelationTree
from cbdsl.learning.always import Always
from cbdsl.learning.catalogs.relation_tree import NamedImpedance, grow_relations, larger_impedances
from cbdsl.learning.experience import Experience
from cbdsl.learning.knowledge_documents import curve_of
from cbdsl.learning.learner import TrialSummary
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.transition import Transition
from cbdsl.runtime.policies.learned_policy import own_policy
from cbdsl.runtime.policies.policy import Policy
from cbdsl.types.decision_tree import Leaf, Tree
from cbdsl.types.direction import DIRECTIONS, unit_of


class NameRelationsConstants(Section):
    """Constants of the tree of relations."""

    least_profiles: PositiveCount = 2
    """Fewest profiles of a leaf."""


class NameRelations:
    """Decision tree from the impedance of two objects to the name of their relation.

    The stage names the relation of each context. Episodes without a complete profile, and contexts
    without a name, teach nothing.

    Args:
        actions: Names of the actions.
        constants: Constants of the algorithm.
        programs: Actions that are programs, by the place of their predicates in a state.
    """

    Constants = NameRelationsConstants

    def __init__(
        self,
        actions: Sequence[str],
        constants: NameRelationsConstants,
        programs: Mapping[int, str] = MappingProxyType({}),
    ) -> None:
        self._first, self._constants = actions[0] if actions else "", constants
        self._program: CheckedProgram | None = None
        self._known: list[NamedImpedance] = []

    def adopt(self, program: CheckedProgram) -> None:
        """Set the program of the tests, whose own policy is followed."""
        self._program = program

    def recall(self, earlier: RelationsDocument) -> None:
        """Add the samples of an earlier document, before the first episode."""
        self._known.extend(
            NamedImpedance(dict(zip(DIRECTIONS, sample, strict=True)), relation)
            for relation, samples in earlier.samples.items()
            for sample in samples
        )

    def see(self, transition: Transition) -> None:
        """Ignore the transition, because a profile is complete only at the end of an episode."""

    def remember(self, experience: Experience) -> None:
        """Add the impedance of a finished episode."""
        if experience.relation and experience.profile.is_whole:
            impedances = larger_impedances(experience.profile)
            rounded = {name: float(f"{value:.4g}") for name, value in impedances.items()}
            self._known.append(NamedImpedance(rounded, experience.relation))

    def policy(self, rng: np.random.Generator) -> Policy:
        """Return the program's own policy, because nothing is explored."""
        return Always(self._first) if self._program is None else own_policy(self._program)

    def greedy(self) -> dict[str, str]:
        """Return the program's own policy, which is not learned."""
        return {} if self._program is None else dict(self._program.policy)

    def densities(self) -> dict[str, Kernel | Gaussian]:
        """Return no densities, because internal models are not learned."""
        return {}

    def documents(self, summary: TrialSummary) -> list[Document]:
        """Return the relations with their samples and provenance.

        Raises:
            UsageError: No episode had a complete profile and a named relation.
        """
        if not self._known:
            raise UsageError(
                f"{summary.program.name}: none of {len(summary.experiences)} episodes tested all "
                "directions of two objects whose relation the stage names; nothing was learned"
            )
        tree = grow_relations(self._known, self._constants.least_profiles)
        return [
            RelationsDocument(
                cbdsl=1,
                kind="relations",
                name=summary.name,
                description="Learned by NAME_RELATIONS; provenance gives the command.",
                robot=summary.program.robot,
                program=summary.program.name,
                tree=_written(tree),
                samples=self._samples(),
                curve=curve_of(summary.experiences),
                provenance=summary.provenance,
            )
        ]

    def _samples(self) -> dict[str, tuple[tuple[float, ...], ...]]:
        names = sorted({each.relation for each in self._known})
        return {
            name: tuple(
                tuple(each.impedances[direction] for direction in DIRECTIONS)
                for each in self._known
                if each.relation == name
            )
            for name in names
        }


def _written(tree: Tree[str]) -> RelationTree:
    """Return a tree in the form of documents."""
    if isinstance(tree, Leaf):
        return str(tree.answer)
    question = {
        "if": f"{tree.feature} > {tree.threshold:g} {unit_of(tree.feature)}",
        "then": _written(tree.above),
        "else": _written(tree.below),
    }
    return RelationQuestion.model_validate(question)
