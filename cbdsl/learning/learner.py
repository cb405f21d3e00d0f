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
from cbdsl.types.policy import Policy
from cbdsl.types.registry import PluginError, Registry

if TYPE_CHECKING:
    import numpy as np


class TrialSummary(NamedTuple):
    """Finished trial, as the documents of its knowledge need it.

    Attributes:
        name: of the policy; other documents have names that begin with it.
        program: what was learned.
        models: by internal model of the program that starts uniform, the effector that it is of.
        experiences: all episodes.
        provenance: what the outcome depends on.
    """

    name: str
    program: CheckedProgram
    models: Mapping[str, str]
    experiences: Sequence[Experience]
    provenance: Provenance


class Learner(Protocol):
    """Learning algorithm with its knowledge; equal experience leaves equal knowledge.

    All chance comes from the generators that it is given.
    """

    def see(self, transition: Transition) -> None:
        """Take in one transition, before the next action is chosen."""
        ...

    def remember(self, experience: Experience) -> None:
        """Take in a finished episode, besides its transitions."""
        ...

    def policy(self, rng: np.random.Generator) -> Policy:
        """Policy of the next episode, which may explore."""
        ...

    def greedy(self) -> dict[str, str]:
        """Best known action, by state or pattern of states."""
        ...

    def densities(self) -> dict[str, Kernel | Gaussian]:
        """Internal models by effector, from which the program's controllers draw references."""
        ...

    def documents(self, summary: TrialSummary) -> list[Document]:
        """Knowledge, each document before those that name it; the policy is last."""
        ...


def replay(learner: Learner, experience: Experience) -> None:
    """Have a learner take in an episode that was finished before."""
    for transition in experience.transitions:
        learner.see(transition)
    learner.remember(experience)


class LearnerClass(Protocol):
    """Class of learners, registered under the name that ``cb learn --learner`` takes.

    Attributes:
        Constants: its constants: a section with defaults and a docstring for each.
    """

    Constants: type[Section]

    def __call__(
        self, actions: Sequence[str], constants: Any, programs: Mapping[int, str]
    ) -> Learner:
        """Learner that knows nothing yet.

        Args:
            actions: what can be chosen.
            constants: an instance of ``Constants``.
            programs: those actions that are programs, by the place of their predicate in a state.
        """
        ...


def first_line(learner: LearnerClass) -> str:
    """First line of a learner's docstring."""
    return (learner.__doc__ or "").strip().partition("\n")[0]


_METHODS = ("see", "remember", "policy", "greedy", "densities", "documents")


def _learner_class(_: str, offered: Any) -> LearnerClass:
    """Class with all methods of ``Learner`` and constants that have defaults."""
    lacking = [method for method in _METHODS if not callable(getattr(offered, method, None))]
    if lacking:
        raise PluginError(f"lacks the methods {', '.join(lacking)}")
    constants = getattr(offered, "Constants", None)
    if not (isinstance(constants, type) and issubclass(constants, Section)):
        raise PluginError("lacks Constants, a subclass of cbdsl.documents.document.Section")
    needed = [name for name, field in constants.model_fields.items() if field.is_required()]
    if needed:
        raise PluginError(f"its constants have no default: {', '.join(needed)}")
    checked: LearnerClass = offered
    return checked


@runtime_checkable
class SchemaLearner(Protocol):
    """Learner of how a schema allocates its actions."""

    def adopt(self, program: CheckedProgram) -> None:
        """Take up the schema before its first episode."""
        ...


ACCOMMODATE, ASSIMILATE = "accommodate", "assimilate"

LEARNERS: Registry[LearnerClass] = Registry(
    "learner",
    "cbdsl.learners",
    {
        ACCOMMODATE: "cbdsl.learning.accommodate:Accommodate",
        ASSIMILATE: "cbdsl.learning.assimilate:Assimilate",
    },
    _learner_class,
)
