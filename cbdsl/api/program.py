"""Checked programs, their parts, and the policies that choose among their actions.

All of them are immutable: a variant of a program is ``program._replace(...)``.
"""

from __future__ import annotations

from cbdsl.language.expression import SUBJECT_TO
from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.program.controller import Composition, Controller, Primitive, Relative
from cbdsl.program.schema import NO_FEATURES, Features, Ranking, Schema
from cbdsl.program.state_values import state_values
from cbdsl.runtime.policies.learned_policy import own_policy
from cbdsl.runtime.policies.policy import Choice, DeferredPolicy, Policy, WrittenPolicy
from cbdsl.runtime.policies.schema_policy import SchemaPolicy
from cbdsl.types.decision_tree import Split, Tree, decide, splits
from cbdsl.types.state import ANY, Predicate, closest_first, matches, overlap

__all__ = [
    "ANY", "NO_FEATURES", "SUBJECT_TO", "Action", "CheckedProgram", "Choice", "Composition",
    "Controller", "DeferredPolicy", "Features", "Policy", "Predicate", "Primitive", "Ranking",
    "Relative", "Schema", "SchemaPolicy", "Split", "Tree", "WrittenPolicy", "closest_first",
    "decide", "matches", "overlap", "own_policy", "splits", "state_values",
]  # fmt: skip
