"""Automaton of a checked program."""

from __future__ import annotations

from cbdsl.checking.knowledge.impossible_states import is_always_defined
from cbdsl.program.automaton import LETTERS, Automaton, Tables, of_tables
from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.types.state import Predicate


def automaton_of(program: CheckedProgram) -> Automaton | None:
    """Return the automaton of a program's policy; ``None`` if it has none or no start."""
    reasons = {pattern: program.reasons.get(pattern, "") for pattern in program.failure}
    tables = Tables(program.policy, program.success, reasons)
    active = {action.name: active_members(action) for action in program.actions}
    values = {member: values_of(member, program) for member in program.members}
    return of_tables(tables, program.members, active, values)


def active_members(action: Action) -> tuple[str, ...]:
    """Return the names of the members that are active while an action runs."""
    if action.composition is None:
        return (action.name,)
    return tuple(primitive.name for primitive in action.composition.primitives)


def values_of(member: str, program: CheckedProgram) -> str:
    """Return the letters that a member can have while it is active."""
    primitive = program.primitives.get(member)
    is_defined = primitive is not None and is_always_defined(primitive.lead)
    return LETTERS.replace(Predicate.UNDEFINED, "") if is_defined else LETTERS
