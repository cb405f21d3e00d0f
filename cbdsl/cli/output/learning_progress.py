"""Progress of trials: one live line on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
import time
from collections import defaultdict, deque
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from cbdsl.cli.output.terminal import console
from cbdsl.learning.experience import Experience
from cbdsl.training.task_observer import TaskObserver

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

#: Least time between lines that stay, s.
_PAUSE = 1.0
_RECENT = 10


class LearningProgress(TaskObserver[Experience]):
    """Observer that prints each episode, the last ten in brief, and the time left.

    Args:
        title: Title of the progress.
        trials: Number of trials.
        episodes: Number of episodes of each trial.
        at_once: Number of simultaneous trials.

    Attributes:
        at_once: Number of simultaneous trials; it may change.
    """

    def __init__(self, title: str, trials: int, episodes: int, at_once: int = 1) -> None:
        self._title: str | None = title
        self._trials, self._episodes = trials, episodes
        self.at_once = at_once
        self._over: dict[int, int] = defaultdict(int)
        last_ten = partial[deque[Experience]](deque, maxlen=_RECENT)
        self._recent: dict[int, deque[Experience]] = defaultdict(last_ten)
        self._seconds: deque[float] = deque(maxlen=_RECENT * at_once)
        # The first episode is reported immediately.
        self._printed = -_PAUSE
        self._bar: tuple[Progress, TaskID] | None = None

    def __enter__(self) -> LearningProgress:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar[0].stop()

    @property
    def total(self) -> int:
        """Number of episodes of all trials."""
        return self._trials * self._episodes

    @property
    def over(self) -> int:
        """Number of finished episodes, as far as known."""
        return sum(self._over.values())

    def begin(self, number: int, renderer: str, finished: Sequence[Experience]) -> None:
        """Report the start of a trial; see ``TaskObserver.begin``."""
        if self._title is not None:
            print(f"{self._title}; images by {renderer}", flush=True)
            self._title = None
        self._over[number] = len(finished)
        self._recent[number].extend(finished[-_RECENT:])
        if finished:
            status = f"{len(finished)} of {self._episodes} episodes are over"
            print(f"{self._name(number, ': ')}{status}", flush=True)
        if sys.stdout.isatty() and self._bar is None:
            # The widths keep the line within 80 characters.
            self._bar = _bar(self.total, width=16 if self._trials == 1 else 8)
            self._bar[0].start()
        if self._bar is not None:
            self._bar[0].update(self._bar[1], completed=self.over)

    def note(self, number: int, item: Experience) -> None:
        """Report a finished episode; see ``TaskObserver.note``."""
        self._over[number] += 1
        self._recent[number].append(item)
        self._seconds.append(item.wall_seconds)
        if self._bar is not None:
            bar, task = self._bar
            status = f"{self._name(number, ', ')}{self._lately(number)}"
            bar.update(task, completed=self.over, status=status)
        # Fast episodes are reported in part, but the last one of a trial always is.
        elif time.monotonic() >= self._printed + _PAUSE or self._over[number] == self._episodes:
            self._printed = time.monotonic()
            print(self._line(number, item), flush=True)

    def _line(self, number: int, last: Experience) -> str:
        where = f"episode {self._over[number]} of {self._episodes}"
        what = f"{last.context}, reward {last.reward} in {len(last.transitions)} transitions"
        parts = [f"{self._name(number, ', ')}{where}: {what}", self._lately(number)]
        if self._trials > 1:
            parts.append(f"{self.over} of {self.total} in all")
        return "; ".join(parts) + self._left()

    def _name(self, number: int, end: str) -> str:
        return f"trial {number}{end}" if self._trials > 1 else ""

    def _lately(self, number: int) -> str:
        """Return a summary of the last ten episodes of a trial."""
        recent = self._recent[number]
        rewarded = sum(each.reward > 0 for each in recent)
        each_transition = sum(e.reward for e in recent) / sum(len(e.transitions) for e in recent)
        return f"last {len(recent)}: {rewarded} rewarded, {each_transition:.2f} per transition"

    def _left(self) -> str:
        """Return the remaining time, estimated from the duration of the last episodes."""
        # Never empty here: lines are printed after an episode. The estimate assumes that `at_once`
        # episodes end in the time of one.
        each = sum(self._seconds) / len(self._seconds)
        left = each * (self.total - self.over) / self.at_once
        return f"; about {left // 60:.0f} min {left % 60:02.0f} s left" if left else ""


def _bar(total: int, width: int) -> tuple[Progress, TaskID]:
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
    from rich.progress import TimeRemainingColumn as Left

    status = TextColumn("{task.fields[status]}")
    columns = (MofNCompleteColumn(), BarColumn(bar_width=width), Left(), status)
    bar = Progress(
        *columns, refresh_per_second=2, console=console()
    )  # drawing it takes time of the episodes
    return bar, bar.add_task("", total=total, status="")
