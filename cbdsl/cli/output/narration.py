"""Output of a run: lines per transition, causes per level, or one JSON object per episode."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict

from cbdsl.diagnostics.counting import some
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.edit import EditTaken
from cbdsl.program.transition import Transition
from cbdsl.program.uses import by_use, of_use
from cbdsl.reporting.automaton_text import AutomatonData, automaton_data, transition_text
from cbdsl.runtime.episode_observer import EpisodeObserver
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.explanation import Explanation, LevelExplanation, TickExplanation
from cbdsl.runtime.tick import Tick

#: Simulated time between tables while nothing changes, s.
_PAUSE = 1.0

# As wide as the time in front of a table.
_INDENT = " " * 12
_HEADINGS = ("level", "phi", "predicted", "measured", "achieved", "rank", "s_min", "others")


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


class StackNarration(EpisodeObserver):
    """Printer of a table of the levels at every transition, and every second between them.

    ``predicted`` and ``measured`` are the changes of phi since the last table: the first-order
    prediction from the law's steps, and the actual change.
    """

    def __init__(self) -> None:
        self._explanation = Explanation()
        self._printed = 0.0
        self._changes: dict[str, tuple[float, float]] = {}
        self._last = TickExplanation((), ())
        # Number of ticks since the last table in which each guard held.
        self._held: Counter[str] = Counter()
        self._ticks = 0

    def note_transition(self, transition: Transition) -> None:
        """Print the levels that led to a transition, once for simultaneous transitions."""
        if self._changes:
            self._tell(transition.time)

    def note_tick(self, tick: Tick) -> None:
        """Record a tick; call it once per tick."""
        self._last = self._explanation.note(tick)
        self._held.update(self._last.guards)
        self._ticks += 1
        for level in self._last.levels:
            predicted, measured = self._changes.get(level.name, (math.nan, math.nan))
            # Both sums have the same ticks, so that prediction and measurement can be compared.
            if not math.isnan(level.measured):
                predicted = _sum(predicted, level.predicted)
                measured = _sum(measured, level.measured)
            self._changes[level.name] = (predicted, measured)
        if tick.observation.time >= self._printed + _PAUSE:
            self._tell(tick.observation.time)

    def _tell(self, time: float) -> None:
        rows = [_HEADINGS, *(_row(each, self._changes[each.name]) for each in self._last.levels)]
        self._printed, self._changes = time, {}
        if len(rows) > 1:
            heading, *lines = _aligned(rows)
            print("\n".join([f"  {time:6.2f} s  {heading}", *(_INDENT + line for line in lines)]))
        if self._last.at_limits:
            print(f"{_INDENT}at their limits: {', '.join(self._last.at_limits)}")
        for clause in self._last.distances:
            print(f"{_INDENT}{clause}")
        if self._held:
            held = self._held.most_common()
            shares = [f"{name} ({100 * count / self._ticks:.0f} %)" for name, count in held]
            print(f"{_INDENT}gave way to guards, share of the ticks: {some(shares, 4)}")
        self._held.clear()
        self._ticks = 0


def _sum(so_far: float, change: float) -> float:
    """Return the sum of a change and the earlier changes; NaN means no earlier change."""
    return change if math.isnan(so_far) else so_far + change


def _row(level: LevelExplanation, changes: tuple[float, float]) -> tuple[str, ...]:
    numbers = [_number(each) for each in (level.phi, *changes)]
    share = _number(level.share, ".2f")
    smallest = _number(level.singular_value, ".2g")
    return (level.name, *numbers, share, str(level.rank), smallest, _others(level))


def _others(level: LevelExplanation) -> str:
    """Return the effect of other levels, or of limits, on a level."""
    if level.pushed_by:
        return f"pushed on by {level.pushed_by}"
    return f"held by {level.held_by}" if level.held_by else ""


def _number(value: float, how: str = ".3g") -> str:
    return "-" if math.isnan(value) else format(value, how)


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return the lines of a table, with names aligned left and numbers aligned right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for row in rows:
        cells = [
            cell.ljust(width) if place in (0, len(row) - 1) else cell.rjust(width)
            for place, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append("  ".join(cells).rstrip())
    return lines
