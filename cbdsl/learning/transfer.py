"""TRANSFER: a policy of one robot with allocations and internal models of another (Section 8.2)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from cbdsl.documents.document import Document
from cbdsl.documents.model import Gaussian, Kernel
from cbdsl.learning.accommodate import RewardedConfigurations
from cbdsl.learning.assimilate import Assimilate, AssimilateConstants
from cbdsl.learning.constants import DensityConstants
from cbdsl.learning.experience import Experience
from cbdsl.learning.knowledge_documents import model_documents
from cbdsl.learning.learner import TrialSummary


class TransferConstants(DensityConstants, AssimilateConstants):
    """Constants of Algorithm 2, and of the densities that are learned beside it."""


# The declarative part of a schema, its policy over abstract actions, names no robot (Section 5.3).
# It is kept. The procedural part is about one body: which of its resources to use in which context,
# and where its effectors are rewarded. It is learned from the first episode on.
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
