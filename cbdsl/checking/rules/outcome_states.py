"""Ends of a program: states of success and of failure, which have to occur and to differ."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from cbdsl.checking.knowledge.impossible_states import is_always_defined
from cbdsl.checking.knowledge.states import is_sound
from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.diagnostics.diagnostic import Place
from cbdsl.diagnostics.outcome import Outcome
from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.program.policy_table import PolicyTable
from cbdsl.types.state import ANY, Predicate, matches, overlap

# Reachability is over-approximated. While an action runs, its members may have any predicate but X,
# and an always defined member is never undefined. All other members are X. Every combination of
# these letters counts as possible. A final state that is unreachable in this model is therefore
# never reached. The reverse does not hold: the physical world may exclude a state that the model
# reaches.

# Handwritten actions have fewer states; a malicious document has any number.
_MOST_STATES = 20_000


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
    possible = []
    for end in ends:
        reasons = [_reason(end.pattern, action, program) for action in program.actions]
        if all(reasons):
            place = _place(context, end.steps)
            context.add("CB480", place, state=end.pattern, problem=min(reasons, key=len))
        else:
            possible.append(end)
    for i, one in enumerate(possible):
        for other in possible[i + 1 :]:
            both = overlap(one.pattern, other.pattern)
            if both is not None and one.steps[0] != other.steps[0]:
                related = [(_place(context, one.steps), f"'{one.pattern}' is here")]
                place = _place(context, other.steps)
                details = {"state": other.pattern, "other": one.pattern, "example": both}
                context.add("CB481", place, related=related, **details)
    if not context.diagnostics.failed:
        _check_reached(context, program, possible)


def _check_reached(context: ProgramContext, program: CheckedProgram, ends: Sequence[End]) -> None:
    """Warn of final states that the program's own policy never leads to."""
    if not program.policy:
        return
    possible = {each.name: _letters(each, program) for each in program.actions}
    if sum(math.prod(map(len, letters)) for letters in possible.values()) > _MOST_STATES:
        return
    reached = _reached(program, possible)
    for end in ends:
        showing = [name for name, letters in possible.items() if _may_be(end.pattern, letters)]
        if not reached.isdisjoint(showing):
            continue
        if showing:
            chosen = " and ".join(f"'{name}'" for name in showing)
            place = _place(context, end.steps)
            context.add(
                "CB722",
                place,
                state=end.pattern,
                problem=f"only {chosen} could, which it never chooses",
            )


def _may_be(pattern: str, letters: Sequence[str]) -> bool:
    """Return whether a state with one of some letters for each member matches a pattern."""
    return all(own == ANY or own in some for own, some in zip(pattern, letters, strict=True))


def _reached(program: CheckedProgram, possible: Mapping[str, Sequence[str]]) -> frozenset[str]:
    """Return the names of the actions that the policy may choose from the beginning on."""
    ends = (*program.success, *program.failure)
    table, reached = PolicyTable(program.policy), set[str]()
    # No controller is active at the start, so that each predicate is X.
    states = ["X" * len(program.members)]
    while states:
        state = states.pop()
        name = table.find(state)
        # The possible states of an action do not depend on its first state, so that it is expanded
        # once.
        if name is None or name in reached:
            continue
        reached.add(name)
        after = map("".join, itertools.product(*possible[name]))
        states += [new for new in after if not any(matches(end, new) for end in ends)]
    return frozenset(reached)


def _letters(action: Action, program: CheckedProgram) -> list[str]:
    """Return the predicates that each member may have while an action runs."""
    shown = {action.name}
    if action.composition is not None:
        shown = {primitive.name for primitive in action.composition.primitives}
    letters = []
    for member in program.members:
        primitive = program.primitives.get(member)
        known = primitive is not None and is_always_defined(primitive.lead)
        defined = Predicate.TRANSIENT + Predicate.QUIESCENT
        own = defined if known else Predicate.UNDEFINED + defined
        letters.append(own if member in shown else Predicate.INACTIVE.value)
    return letters


def _reason(pattern: str, action: Action, program: CheckedProgram) -> str:
    """Return why a pattern never occurs while an action runs, as a clause; empty if it may."""
    shown = {action.name}
    if action.composition is not None:
        shown = {primitive.name for primitive in action.composition.primitives}
    for member, letter in zip(program.members, pattern, strict=True):
        if letter == ANY:
            continue
        if (member in shown) == (letter == Predicate.INACTIVE):
            together = "inactive" if member in shown else "active"
            return f"no action leaves '{member}' {together} beside the others"
        primitive = program.primitives.get(member)
        known = primitive is not None and is_always_defined(primitive.lead)
        if letter == Predicate.UNDEFINED and known:
            return f"'{member}' is always defined"
    return ""
