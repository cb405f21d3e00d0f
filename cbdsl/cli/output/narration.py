"""Output of a run: text lines per transition, or one JSON object per episode."""

from __future__ import annotations

import json
from dataclasses import asdict

from cbdsl.program.checked import CheckedProgram
from cbdsl.program.edit import EditTaken
from cbdsl.program.transition import Transition
from cbdsl.program.uses import by_use, of_use
from cbdsl.reporting.automaton_text import AutomatonData, automaton_data, transition_text
from cbdsl.runtime.episode_observer import EpisodeObserver
from cbdsl.runtime.episode_result import EpisodeResult


class Narration(EpisodeObserver):
    """Printer of each transition; those of a program with steps in words, too."""

    def __init__(self) -> None:
        self._automata: dict[str, AutomatonData] = {}

    def begin(self, program: CheckedProgram, stage: str, seed: int) -> None:
        """Note the program that runs."""
        self._follow(program)

    def note_edit(self, edit: EditTaken) -> None:
        """Note an edited program, which has other steps."""
        self._follow(edit.program)

    def _follow(self, program: CheckedProgram) -> None:
        def data(each: CheckedProgram) -> AutomatonData | None:
            is_read = each.steps and not each.is_learned
            return automaton_data(each, is_short=False) if is_read else None

        self._automata = by_use(program, data)

    def note_transition(self, transition: Transition) -> None:
        """Print a transition, indented by how deep its program is used."""
        automaton = of_use(self._automata, transition.program, transition.use)
        words = automaton and transition_text(automaton, transition)
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
