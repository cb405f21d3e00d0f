"""How a trial gets on: a line that is replaced on a terminal, lines that stay elsewhere."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

    from cbdsl.documents.policy import Provenance
    from cbdsl.training.trial import Trial

#: Least time between lines that stay, s.
_PAUSE = 1.0
_RECENT = 10


class LearningProgress:
    """Tells of each episode what it was, how the last ten went, and how long the rest will take."""

    def __init__(self) -> None:
        self._total = 0
        self._seconds: list[float] = []
        self._told = -_PAUSE
        self._bar: tuple[Progress, TaskID] | None = None

    def __enter__(self) -> LearningProgress:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar[0].stop()

    def begin(self, trial: Trial, provenance: Provenance) -> None:
        """See ``Watcher.begin``."""
        self._total, over = provenance.episodes, len(trial.experiences)
        number = f", trial {trial.number}" if trial.number else ""
        print(
            f"{provenance.program.name} on {provenance.stage.name}, seed {trial.seed}{number}; "
            f"images by {provenance.renderer}"
        )
        if over:
            print(f"{over} of {self._total} episodes are over")
        if sys.stdout.isatty():
            self._bar = _bar(self._total, over)
            self._bar[0].start()

    def note(self, trial: Trial, seconds: float) -> None:
        """See ``Watcher.note``."""
        self._seconds.append(seconds)
        done = len(trial.experiences)
        if self._bar is not None:
            bar, task = self._bar
            bar.update(task, completed=done, told=_lately(trial))
        elif time.monotonic() >= self._told + _PAUSE or done == self._total:
            self._told = time.monotonic()
            print(f"episode {done} of {self._total}: {_told(trial)}{self._left(done)}", flush=True)

    def _left(self, done: int) -> str:
        recent = self._seconds[-_RECENT:]
        left = sum(recent) / len(recent) * (self._total - done)
        return f"; about {left // 60:.0f} min {left % 60:02.0f} s left" if left else ""


def _told(trial: Trial) -> str:
    """An episode and the last ten in a few words."""
    last = trial.experiences[-1]
    transitions = len(last.transitions)
    return f"{last.context}, reward {last.reward} in {transitions} transitions; {_lately(trial)}"


def _lately(trial: Trial) -> str:
    recent = trial.experiences[-_RECENT:]
    rewarded = sum(each.reward > 0 for each in recent)
    each_transition = sum(e.reward for e in recent) / sum(len(e.transitions) for e in recent)
    return f"last {len(recent)}: {rewarded} rewarded, {each_transition:.2f} per transition"


def _bar(total: int, gone: int) -> tuple[Progress, TaskID]:
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
    from rich.progress import TimeRemainingColumn as Left

    told = TextColumn("{task.fields[told]}")
    # Everything has room on a line of eighty characters.
    columns = (MofNCompleteColumn(), BarColumn(bar_width=16), Left(), told)
    bar = Progress(*columns)
    return bar, bar.add_task("", total=total, completed=gone, told="")
