"""Knowledge of a trial as documents: a policy and its internal models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from cbdsl.documents.model import Gaussian, Kernel, ModelDocument
from cbdsl.documents.policy import Curve, PolicyDocument
from cbdsl.learning.experience import Experience
from cbdsl.learning.learner import TrialSummary


def learned_by(summary: TrialSummary) -> str:
    """Return the description of a learned document."""
    learner = summary.provenance.algorithm.upper()
    return f"Learned by {learner}; the provenance names its inputs and its command."


def model_documents(
    summary: TrialSummary, densities: Mapping[str, Kernel | Gaussian]
) -> list[ModelDocument]:
    """Return the internal models Pr(tau | sigma, reward), named ``<policy>_<effector>``."""
    program = summary.program
    return [
        ModelDocument(
            cbdsl=1,
            kind="model",
            name=f"{summary.name}_{effector}",
            description=f"Where {effector} was when {program.name} was rewarded.",
            robot=program.robot,
            effector=effector,
            density=density,
        )
        for effector, density in densities.items()
    ]


def policy_document(
    summary: TrialSummary, policy: Mapping[str, str], **learned: Any
) -> PolicyDocument:
    """Return the policy with its learning curve and provenance.

    Args:
        summary: Finished trial.
        policy: Actions by state or pattern.
        learned: Further keys of the document, such as ``values``.
    """
    program = summary.program
    return PolicyDocument(
        cbdsl=1,
        kind="policy",
        name=summary.name,
        description=learned_by(summary),
        program=program.name,
        predicates=program.members,
        policy=dict(policy),
        models={model: f"{summary.name}_{each}" for model, each in summary.models.items()},
        curve=curve_of(summary.experiences),
        provenance=summary.provenance,
        **learned,
    )


def curve_of(experiences: Sequence[Experience]) -> Curve:
    """Return the learning curve of a sequence of episodes."""
    return Curve(
        context=tuple(each.context for each in experiences),
        reward=tuple(each.reward for each in experiences),
        transitions=tuple(len(each.transitions) for each in experiences),
        ticks=tuple(each.ticks for each in experiences),
    )
