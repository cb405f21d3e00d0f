"""Learners: algorithms that learn a program's policy and internal models from episodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, runtime_checkable

from cbdsl.documents.document import Document, Section
from cbdsl.documents.model import Gaussian, Kernel
from cbdsl.documents.policy import Provenance
from cbdsl.learning.experience import Experience
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.transition import Transition
from cbdsl.runtime.policies.policy import Policy
from cbdsl.types.registry import PluginError, Registry

if TYPE_CHECKING:
    import numpy as np

    from cbdsl.documents.relations import RelationsDocument


class TrialSummary(NamedTuple):
    """Finished trial with the data that its documents need.

    Attributes:
        name: Name of the policy, and prefix of the other documents' names.
        program: Learned program.
        models: Effector of each internal model of the program that starts uniform.
        experiences: All episodes.
        provenance: Inputs that determine the outcome.
    """

    name: str
    program: CheckedProgram
    models: Mapping[str, str]
    experiences: Sequence[Experience]
    provenance: Provenance


class Learner(Protocol):
    """Learning algorithm with its knowledge; the same experience gives the same knowledge.

    All randomness comes from the given generators.
    """

    def see(self, transition: Transition) -> None:
        """Learn from one transition, before the next action is chosen."""
        ...

    def remember(self, experience: Experience) -> None:
        """Learn from a finished episode, in addition to its transitions."""
        ...

    def policy(self, rng: np.random.Generator) -> Policy:
        """Return the policy of the next episode, which may explore."""
        ...

    def greedy(self) -> dict[str, str]:
        """Return the best known action, by state or pattern of states."""
        ...

    def densities(self) -> dict[str, Kernel | Gaussian]:
        """Return internal models by effector, from which controllers draw references."""
        ...

    def documents(self, summary: TrialSummary) -> list[Document]:
        """Return the knowledge, each document before its dependants; the policy is last."""
        ...


def replay(learner: Learner, experience: Experience) -> None:
    """Let a learner learn from an earlier episode."""
    for transition in experience.transitions:
        learner.see(transition)
    learner.remember(experience)


class LearnerClass(Protocol):
    """Class of learners, registered under a name for ``cb learn --learner``.

    Attributes:
        Constants: Section of the constants, with a default and a docstring for each.
    """

    Constants: type[Section]

    def __call__(
        self, actions: Sequence[str], constants: Any, programs: Mapping[int, str]
    ) -> Learner:
        """Return a learner without knowledge.

        Args:
            actions: Names of the actions.
            constants: Instance of ``Constants``.
            programs: Actions that are programs, by the place of their predicates in a state.
        """
        ...


def first_line(learner: LearnerClass) -> str:
    """Return the first line of a learner's docstring."""
    return (learner.__doc__ or "").strip().partition("\n")[0]


_METHODS = ("see", "remember", "policy", "greedy", "densities", "documents")


def _learner_class(_: str, offered: Any) -> LearnerClass:
    """Return the class if it has all methods of ``Learner`` and constants with defaults."""
    lacking = [method for method in _METHODS if not callable(getattr(offered, method, None))]
    if lacking:
        raise PluginError(f"lacks the methods {', '.join(lacking)}")
    constants = getattr(offered, "Constants", None)
    if not (isinstance(constants, type) and issubclass(constants, Section)):
        raise PluginError("lacks Constants, a subclass of cbdsl.extend.learner.Section")
    needed = [name for name, field in constants.model_fields.items() if field.is_required()]
    if needed:
        raise PluginError(f"its constants have no default: {', '.join(needed)}")
    checked: LearnerClass = offered
    return checked


@runtime_checkable
class SchemaLearner(Protocol):
    """Learner that follows the policy of the program, such as that of a schema."""

    def adopt(self, program: CheckedProgram) -> None:
        """Set the program before its first episode."""
        ...


@runtime_checkable
class ContinuingLearner(Protocol):
    """Learner that can go on from earlier knowledge of its own kind."""

    def recall(self, earlier: RelationsDocument) -> None:
        """Adopt earlier knowledge before the first episode."""
        ...


ACCOMMODATE, ASSIMILATE, TRANSFER = "accommodate", "assimilate", "transfer"
NAME_RELATIONS = "name_relations"

LEARNERS: Registry[LearnerClass] = Registry(
    "learner",
    "cbdsl.learners",
    {
        ACCOMMODATE: "cbdsl.learning.accommodate:Accommodate",
        ASSIMILATE: "cbdsl.learning.assimilate:Assimilate",
        TRANSFER: "cbdsl.learning.assimilate:Transfer",
        NAME_RELATIONS: "cbdsl.learning.catalogs.name_relations:NameRelations",
    },
    _learner_class,
)
