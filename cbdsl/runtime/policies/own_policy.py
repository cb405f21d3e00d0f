"""Default policy of a program."""

from __future__ import annotations

from cbdsl.program.checked import CheckedProgram
from cbdsl.runtime.policies.learned_policy import LearnedPolicy
from cbdsl.runtime.policies.policy import Policy, WrittenPolicy
from cbdsl.runtime.policies.schema_policy import SchemaPolicy


def own_policy(program: CheckedProgram) -> Policy:
    """Return the policy of a schema, a learned table or a written one, at its beginning."""
    if program.schema is not None:
        return SchemaPolicy(program)
    return LearnedPolicy(program) if program.is_learned else WrittenPolicy(program.policy)
