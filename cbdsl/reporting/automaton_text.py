"""Automata of programs as data, and transitions in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from cbdsl.checking.rules.flow import automaton_of
from cbdsl.language.exit import WORDS, when_text
from cbdsl.program.automaton import ProgramStep
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.exit_list import with_short_exits
from cbdsl.program.transition import Transition
from cbdsl.program.uses import by_use
from cbdsl.types.state import ANY, ARRIVED, STUCK, Predicate

AutomatonData = Mapping[str, Any]


def automata(program: CheckedProgram, *, is_short: bool = True) -> dict[str, AutomatonData]:
    """Return the automata of a program and of the programs that it uses; see ``of_use``.

    A program without a written policy has none.

    Args:
        program: Program.
        is_short: True for short lists of exits, which take longer to find.
    """

    def data(each: CheckedProgram) -> AutomatonData | None:
        return None if each.is_learned else automaton_data(each, is_short=is_short)

    return by_use(program, data)


def automaton_data(program: CheckedProgram, *, is_short: bool = True) -> dict[str, Any] | None:
    """Return the steps of a program with their exits; without steps, its actions are steps.

    An exit has its condition in words, and the letters of the members that it names. Members that
    are programs or conditions have their kind, and conditions the components that they compare.
    """
    automaton = automaton_of(program)
    if automaton is None:
        return None
    kinds = member_kinds(program)
    uses = {action.name: action.program.name for action in program.actions if action.program}
    steps = automaton.steps.values()
    # Steps as written are the shortest to read.
    is_short &= not program.steps
    return {
        "members": list(program.members),
        "start": automaton.start,
        "steps": [
            {
                "step": step.name,
                "action": step.action,
                "program": uses.get(step.action, ""),
                "exits": list(_exits(step, kinds)),
            }
            for step in (map(with_short_exits, steps) if is_short else steps)
        ],
        "kinds": kinds,
        "compared": {
            each.name: [
                [component.resource.name, component.axis]
                for comparison in each.comparisons
                for component in comparison.factors
            ]
            for each in program.conditions.values()
        },
        "reward_ends": program.reward_ends,
    }


def member_kinds(program: CheckedProgram) -> dict[str, str]:
    """Return the kinds of the members that are no controllers: ``program`` or ``condition``."""
    kinds = {action.name: "program" for action in program.actions if action.program is not None}
    return kinds | dict.fromkeys(program.conditions, "condition")


def _exits(step: ProgramStep, kinds: Mapping[str, str]) -> Iterator[dict[str, Any]]:
    for exit_, box in ((each, box) for each in step.exits for box in each.boxes):
        parts = zip(step.members, box, step.values, strict=True)
        # A member whose tolerance decides nothing may be stuck, too.
        letters = {
            name: own if name in kinds or STUCK in every else own.replace("1", "1s")
            for name, own, every in parts
            if not set(every) <= set(own)
        }
        if letters or exit_.to.step != step.name:
            when = when_text(step.members, box, step.values, kinds)
            yield {"when": when, "to": str(exit_.to), "letters": letters}
        if not letters:
            return  # it always holds


def transition_text(automaton: AutomatonData, made: Transition) -> str:
    """Return a transition in words, such as ``lift -> carry, since lift is at rest``.

    Args:
        automaton: Automaton of its program.
        made: Transition.

    Returns:
        Text; empty without a change of state, and for an action that is no step.
    """
    step = next((each for each in automaton["steps"] if each["action"] == made.action), None)
    members = automaton["members"]
    letters = dict(zip(members, made.next_state, strict=True)) | dict.fromkeys(made.stuck, STUCK)
    before = dict(zip(members, made.state, strict=True))
    changed = {
        name: letters[name]
        for name, letter in zip(members, made.next_state, strict=True)
        if letter not in (before[name], Predicate.INACTIVE)
    }
    if step is None or not changed:
        return ""
    holding = (each for each in step["exits"] if _holds(each["letters"], letters))
    exit_ = next(holding, {"to": step["step"], "letters": {}})
    reason, to = changed.keys() & exit_["letters"], exit_["to"]
    if to == "succeed" and any(letters[name] == STUCK for name in exit_["letters"]):
        to = f"fail {made.reason}".rstrip()  # a success asks for arrival
    if made.reward and automaton["reward_ends"] and to.split()[0] not in ("succeed", "fail"):
        reason, to = set(made.rewarding), "the end"
    if to != step["step"]:
        # The change that made the exit hold is its reason; its other parts held before.
        named = {name: letter for name, letter in changed.items() if name in reason} or changed
        return f"{step['step']} -> {to}, since {clauses(named, automaton['kinds'])}"
    begins = all(before[name] == Predicate.INACTIVE for name in changed)
    if begins:
        changed = {name: letter for name, letter in changed.items() if letter != "0"}
    words = clauses(changed, automaton["kinds"])
    return f"{step['step']} {'begins' if begins else 'goes on'}{': ' if words else ''}{words}"


def _holds(exit_letters: Mapping[str, str], letters: Mapping[str, str]) -> bool:
    return all(letters[name] in own for name, own in exit_letters.items())


def clauses(letters: Mapping[str, str], kinds: Mapping[str, str]) -> str:
    """Return the values of members as clauses, such as ``lift is at rest``."""
    return ", ".join(f"{name} {_value(kinds.get(name), own)}" for name, own in letters.items())


def state_text(members: Sequence[str], state: str, kinds: Mapping[str, str]) -> str:
    """Return a state or a pattern by its active members: ``reach is at rest, touch is moving``."""
    silent = (Predicate.INACTIVE, ANY)
    active = {name: own for name, own in zip(members, state, strict=True) if own not in silent}
    return clauses(active, kinds) or ("any" if ANY in state else "nothing is active")


def _value(kind: str | None, letter: str) -> str:
    if letter in (ARRIVED, STUCK):
        return "is stuck" if letter == STUCK else "has arrived"
    words = WORDS[kind or "controller"]
    word = next(word for word, letters in words.items() if letter in letters)
    return word if word in ("failed", "succeeded") else f"is {word}"
