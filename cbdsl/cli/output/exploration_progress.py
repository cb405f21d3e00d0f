"""Progress of ``cb explore``: one line per action, and remarks."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Sequence

from cbdsl.learning.catalogs.action_outcome import ActionOutcome
from cbdsl.training.exploration.action_work import FinishedAction
from cbdsl.training.task_observer import TaskObserver

# Actions after which an object that was never seen is gone, and a last time counts for the rest.
_GONE, _RECENT = 5, 20


class ExplorationProgress(TaskObserver[FinishedAction]):
    """Printer of the outcome of each action.

    Args:
        total: Maximum number of actions.
        as_json: True for output as JSON.
        looks_ahead: True if outcomes include the observation after the action.
    """

    def __init__(self, total: int, *, as_json: bool = False, looks_ahead: bool = True) -> None:
        self._total, self._as_json = total, as_json
        self._looks_ahead = looks_ahead
        self._unseen = self._done = 0
        self._seconds: deque[float] = deque(maxlen=_RECENT)

    def begin(self, number: int, renderer: str, finished: Sequence[FinishedAction]) -> None:
        """Count the actions that were finished earlier; see ``TaskObserver.begin``."""
        self._done = len(finished)

    def note(self, number: int, item: FinishedAction) -> None:
        """Report a finished action; see ``TaskObserver.note``."""
        outcome, step = item
        self._done += 1
        self._seconds.append(outcome.wall_seconds)
        if self._as_json:
            self._print_json(item)
            return
        mark = "rewarded" if step.rewarded else "no reward" if step.action != "noop" else ""
        left = sum(self._seconds) / len(self._seconds) * (self._total - self._done)
        time = f"; about {left // 60:.0f} min {left % 60:02.0f} s left" if left else ""
        line = f"{step.action:20s} {mark:9s} r {step.reward:+.3f}{time}"
        print(f"{self._done} of {self._total}: {line}", flush=True)
        for name in outcome.opened:
            print(f"  found: {name}", flush=True)
        if outcome.failed:
            print(f"  {step.action} is left out from now on: {outcome.ending}", flush=True)
        self._tell_of_absence(outcome)

    def _tell_of_absence(self, outcome: ActionOutcome) -> None:
        self._unseen = 0 if outcome.ahead else self._unseen + 1
        # Equality reports an absence once, until the object is seen again.
        if self._looks_ahead and self._unseen == _GONE:
            print(f"  nothing that can be acted on was seen after the last {_GONE} actions")

    def _print_json(self, action: FinishedAction) -> None:
        row = {"number": self._done, **action.step._asdict(), **action.outcome.as_data()}
        row["reward"] = action.step.reward
        del row["wall_seconds"]
        print(json.dumps(row), flush=True)
