"""The policy that a program runs under where no other one is given."""

from __future__ import annotations

from cbdsl.program.checked import CheckedProgram
from cbdsl.program.learned_policy import LearnedPolicy
from cbdsl.program.schema_policy import SchemaPolicy
from cbdsl.types.policy import Policy, WrittenPolicy


def own_policy(program: CheckedProgram) -> Policy:
    """The policy of a schema, of a learned table or of a written one, at its beginning."""
    if program.schema is not None:
        return SchemaPolicy(program)
    return LearnedPolicy(program) if program.is_learned else WrittenPolicy(program.policy)
