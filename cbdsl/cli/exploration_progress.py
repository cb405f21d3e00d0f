"""Progress of ``cb explore``: one line per action, and remarks."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.learning.action_outcome import ActionOutcome
    from cbdsl.learning.exploration import ExplorationStep

# Actions after which an object that was never seen is gone, and a last time counts for the rest.
_GONE, _RECENT = 5, 20


class ExplorationProgress:
    """Printer of the outcome of each action.

    Args:
        total: Maximum number of actions.
        as_json: True for output as JSON.
        looks_ahead: True if outcomes include the observation after the action.
    """

    def __init__(self, total: int, *, as_json: bool = False, looks_ahead: bool = True) -> None:
        self._total, self._as_json = total, as_json
        self._looks_ahead = looks_ahead
        self._unseen = 0
        self._seconds: deque[float] = deque(maxlen=_RECENT)

    def note(
        self, number: int, step: ExplorationStep, outcome: ActionOutcome, seconds: float
    ) -> None:
        """Report a finished action; see ``ExplorationObserver``."""
        self._seconds.append(seconds)
        if self._as_json:
            self._print_json(number, step, outcome)
            return
        mark = "rewarded" if step.rewarded else "no reward" if step.action != "noop" else ""
        left = sum(self._seconds) / len(self._seconds) * (self._total - number)
        time = f"; about {left // 60:.0f} min {left % 60:02.0f} s left" if left else ""
        print(
            f"{number} of {self._total}: {step.action:20s} {mark:9s} r {step.reward:+.3f}{time}",
            flush=True,
        )
        for name in outcome.opened:
            print(f"  found: {name}", flush=True)
        if outcome.failed:
            print(f"  {step.action} is left out from now on: {outcome.ending}", flush=True)
        self._tell_of_absence(outcome)

    def _tell_of_absence(self, outcome: ActionOutcome) -> None:
        self._unseen = 0 if outcome.ahead else self._unseen + 1
        if self._looks_ahead and self._unseen == _GONE:
            print(f"  nothing that can be acted on was seen after the last {_GONE} actions")

    def _print_json(self, number: int, step: ExplorationStep, outcome: ActionOutcome) -> None:
        import json

        row = {"number": number, **step._asdict(), **outcome._asdict()}
        row["reward"] = step.reward
        print(json.dumps(row), flush=True)
