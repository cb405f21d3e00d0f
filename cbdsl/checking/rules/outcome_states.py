"""Ends of a program: states of success and of failure, which have to occur and to differ."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from cbdsl.checking.knowledge.states import is_sound
from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.checking.rules.flow import active_members, automaton_of, values_of
from cbdsl.diagnostics.diagnostic import Place
from cbdsl.diagnostics.outcome import Outcome
from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.types.state import ANY, Predicate, overlap

# Reachability is that of the program's automaton, which over-approximates a run. A final state that
# is unreachable in this model is therefore never reached. The reverse does not hold: the physical
# world may exclude a state that the model reaches.


class End(NamedTuple):
    """Pattern of final states, and its path in the document."""

    pattern: str
    steps: Steps


def read_ends(context: ProgramContext, members: Outcome[Sequence[str]]) -> list[End]:
    """Return the valid patterns of success and failure, and report the invalid ones."""
    document, ends = context.document, []
    for key, patterns in (("success", document.success), ("failure", document.failure)):
        for i, pattern in enumerate(patterns):
            steps: Steps = (key, pattern if isinstance(patterns, dict) else i)
            if is_sound(pattern, members, _place(context, steps), context.diagnostics):
                ends.append(End(pattern, steps))
    return ends


def _place(context: ProgramContext, steps: Steps) -> Place:
    """Return the place of a pattern: an item of a list, or a key with a reason."""
    find = context.source.place if isinstance(steps[-1], int) else context.source.key
    return find(*steps)


def check_ends(context: ProgramContext, program: CheckedProgram, ends: Sequence[End]) -> None:
    """Report final states that never occur, and states of success that are also of failure."""
    possible: dict[End, list[str]] = {}
    for end in ends:
        reasons = {each.name: _reason(end.pattern, each, program) for each in program.actions}
        if all(reasons.values()):
            place, problem = _place(context, end.steps), min(reasons.values(), key=len)
            context.add("CB480", place, state=end.pattern, problem=problem)
        else:
            possible[end] = [name for name, reason in reasons.items() if not reason]
    for one, other in itertools.combinations(possible, 2):
        both = overlap(one.pattern, other.pattern)
        if both is not None and one.steps[0] != other.steps[0]:
            related = [(_place(context, one.steps), f"'{one.pattern}' is here")]
            place = _place(context, other.steps)
            details = {"state": other.pattern, "other": one.pattern, "example": both}
            context.add("CB481", place, related=related, **details)
    # Steps state their ends by exits, whose flow is checked.
    if possible and not context.diagnostics.failed:
        _check_reached(context, program, possible)


def _check_reached(
    context: ProgramContext, program: CheckedProgram, ends: Mapping[End, Sequence[str]]
) -> None:
    """Warn of final states that the program's own policy never leads to."""
    automaton = automaton_of(program)
    if automaton is None:
        return
    reached = automaton.paths(automaton.targets())
    for end, showing in ends.items():
        if reached.keys().isdisjoint(showing):
            chosen = " and ".join(f"'{name}'" for name in showing)
            problem = f"only {chosen} could, which it never chooses"
            context.add("CB722", _place(context, end.steps), state=end.pattern, problem=problem)


def _reason(pattern: str, action: Action, program: CheckedProgram) -> str:
    """Return why a pattern never occurs while an action runs, as a clause; empty if it may."""
    shown = active_members(action)
    for member, letter in zip(program.members, pattern, strict=True):
        if letter == ANY:
            continue
        if (member in shown) == (letter == Predicate.INACTIVE):
            together = "inactive" if member in shown else "active"
            return f"no action leaves '{member}' {together} beside the others"
        if letter == Predicate.UNDEFINED and letter not in values_of(member, program, tells=True):
            return f"'{member}' is always defined"
    return ""
