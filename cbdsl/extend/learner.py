"""Learners, for the entry-point group ``cbdsl.learners``.

An entry is a class with the constructor of ``LearnerClass``, its section ``Constants``, and the
methods of ``Learner``. Equal experience and equal generators give equal knowledge, and an instance
can be pickled. A learner raises ``UsageError`` for a program that it cannot learn. The contract
test is ``cbdsl.extend.contract.test_learner``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.extend.lazy_names import lazy_names

if TYPE_CHECKING:
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.documents.document import Document, Section, quantity
    from cbdsl.learning.experience import Experience
    from cbdsl.learning.knowledge_documents import model_documents, policy_document
    from cbdsl.learning.learner import (
        ContinuingLearner,
        Learner,
        LearnerClass,
        SchemaLearner,
        TrialSummary,
    )
    from cbdsl.program.schema import NO_FEATURES, Features
    from cbdsl.program.transition import Transition
    from cbdsl.runtime.policies.policy import Choice, Policy

__all__ = [
    "NO_FEATURES", "Choice", "ContinuingLearner", "Document", "Experience", "Features", "Learner",
    "LearnerClass", "Policy", "SchemaLearner", "Section", "Transition", "TrialSummary",
    "UsageError", "model_documents", "policy_document", "quantity",
]  # fmt: skip

__getattr__ = lazy_names(__file__)
