"""Observer of trials that run in other processes, which keeps its notifications."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from cbdsl.training.learning_task import LearningTask


class Notes:
    """Notifications of a supervisor."""

    def __init__(self) -> None:
        self.files: list[Path] = []
        self.failures: list[str] = []
        self.workers: list[int] = []

    def done(self, task: LearningTask, files: Sequence[Path]) -> None:
        self.files += files

    def failed(self, task: LearningTask, error: Exception) -> None:
        self.failures.append(f"trial {task.number}: {error}")

    def look(self, workers: int) -> None:
        self.workers.append(workers)


def until(so: Callable[[], Any]) -> None:
    """Wait for a condition."""
    while not so():
        time.sleep(0.02)


def episodes(task: LearningTask) -> int:
    """Return the number of finished episodes of a task, whose journal begins with a head."""
    lines = task.journal.read_bytes().count(b"\n") if task.journal.exists() else 0
    return max(lines - 1, 0)
