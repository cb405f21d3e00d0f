"""Output of a run: text lines per transition, or one JSON object per episode."""

from __future__ import annotations

import json
from dataclasses import asdict

from cbdsl.language.exit import WORDS
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.transition import Transition
from cbdsl.runtime.episode_observer import EpisodeObserver
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.tick import Tick
from cbdsl.types.state import Predicate


class Narration(EpisodeObserver):
    """Printer of each transition; those of a program with steps in words, too."""

    def __init__(self) -> None:
        self._program: CheckedProgram | None = None

    def note_tick(self, tick: Tick) -> None:
        """Note the program that runs."""
        self._program = tick.run.program

    def note_transition(self, transition: Transition) -> None:
        """Print a transition."""
        program = self._program and _used(self._program, transition.use)
        _narrate(transition, program and changes(program, transition))


def changes(program: CheckedProgram, transition: Transition) -> str:
    """Return the step of a transition with the members that changed, in words.

    Empty for a program without steps, and for a transition without a change.
    """
    step = program.steps.get(transition.action)
    after = zip(program.members, transition.state, transition.next_state, strict=True)
    words = [
        f"{member} {_word(program, member, letter)}"
        for member, before, letter in after
        if letter not in (before, Predicate.INACTIVE)
    ]
    return f"{step}: {', '.join(words)}" if step and words else ""


def _word(program: CheckedProgram, member: str, letter: str) -> str:
    kind = "controller" if member in program.primitives else "program"
    kind = "condition" if member in program.conditions else kind
    return next(word for word, letters in WORDS[kind].items() if letter in letters)


def _used(program: CheckedProgram, use: str) -> CheckedProgram | None:
    """Return the program behind the names of actions that lead to it, parted by dots."""
    for name in filter(None, use.split(".")):
        inner = next((each.program for each in program.actions if each.name == name), None)
        if inner is None:
            return None
        program = inner
    return program


def _narrate(transition: Transition, words: str | None) -> None:
    """Print a transition, indented by how deep its program is used."""
    indent = "    " * transition.depth
    reward = f"  reward {transition.reward}" if transition.reward else ""
    unchanged = "  (no change)" if transition.state == transition.next_state else ""
    print(
        f"  {transition.time:6.2f} s  {indent}{transition.title}  "
        f"{transition.state} -> {transition.next_state}  "
        f"{words or transition.action}{reward}{unchanged}",
        flush=True,
    )


def json_line(result: EpisodeResult) -> str:
    """Return an episode as a line of JSON; only ``wall_seconds`` depends on the machine."""
    row = asdict(result)
    row["transitions"] = len(result.actions)
    row["wall_seconds"] = round(result.wall_seconds, 3)
    return json.dumps(row, ensure_ascii=False)
