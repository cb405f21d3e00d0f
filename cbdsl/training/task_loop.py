"""Loop of all tasks: one item after another, each in the journal before the next begins."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Protocol, TypeVar

from cbdsl.learning.catalogs.action_outcome import ActionOutcome
from cbdsl.learning.experience import Experience
from cbdsl.training.task_observer import Item, TaskObserver

Row = TypeVar("Row", Experience, ActionOutcome)
Item_co = TypeVar("Item_co", covariant=True)


class Work(Protocol[Row, Item_co]):
    """Task under way on a body.

    Attributes:
        number: Number of the trial.
        renderer: Name of the renderer of the images.
        finished: Items that were finished earlier.
        is_over: True if no item is left.
    """

    @property
    def number(self) -> int: ...
    @property
    def renderer(self) -> str: ...
    @property
    def finished(self) -> Sequence[Item_co]: ...
    @property
    def is_over(self) -> bool: ...

    def run_next(self) -> Row:
        """Run the next item; return its row of the journal."""
        ...

    def note(self, row: Row) -> Item_co:
        """Learn from a row that is in the journal; return the item for observers."""
        ...


def run_items(
    work: Work[Row, Item], append: Callable[[Row], None], observer: TaskObserver[Item]
) -> None:
    """Run the remaining items of a task.

    Args:
        work: Task under way.
        append: Function that writes a row to the journal.
        observer: Observer of the finished items.

    Raises:
        BackendError, EpisodeError: If an item cannot be run.
        OSError: If the journal cannot be written.
    """
    observer.begin(work.number, work.renderer, work.finished)
    while not work.is_over:
        began = time.perf_counter()
        # The item is in the journal before the task goes on. No later item thus depends on one that
        # a resumed task would not find.
        row = work.run_next()
        row = replace(row, wall_seconds=time.perf_counter() - began)
        append(row)
        observer.note(work.number, work.note(row))
