"""Catalog tasks: explorations whose journal of actions becomes a catalog."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from cbdsl.documents.document import Document
from cbdsl.learning.catalogs.action_outcome import ActionOutcome
from cbdsl.storage.atomic_file import remove_leftovers
from cbdsl.training.exploration.action_work import ActionWork, FinishedAction
from cbdsl.training.task_files import exploration_journal, require_free
from cbdsl.training.task_loop import run_items
from cbdsl.training.task_observer import TaskObserver
from cbdsl.yaml_text.writer import write

Catalog = TypeVar("Catalog", bound=Document)


class CatalogTask:
    """Base of explorations, with their files and their end.

    Attributes:
        path: Path of the catalog.
    """

    path: Path

    @property
    def journal(self) -> Path:
        """File of its actions, each written when it is over."""
        return exploration_journal(self.path)

    def require_ready(self, *, resume: bool) -> None:
        """Check that the outcome can be written, before the robot moves.

        Raises:
            JournalError: If other files are in the way.
            OSError: If the files cannot be written.
        """
        self.path.parent.mkdir(parents=True, exist_ok=True)
        require_free(self.journal, [self.path], "explored", resume=resume)

    def complete(
        self,
        work: ActionWork,
        append: Callable[[ActionOutcome], None],
        observer: TaskObserver[FinishedAction] | None,
        document: Callable[[], Catalog],
    ) -> Catalog:
        """Run the remaining actions, and write the catalog.

        Args:
            work: Exploration under way.
            append: Function that writes an outcome to the locked journal.
            observer: Observer of the completed actions.
            document: Function that returns the catalog after the last action.

        Raises:
            OSError: If journal or catalog cannot be written.
        """
        run_items(work, append, observer or TaskObserver())
        catalog = document()
        # The locked journal ensures that no other process writes the catalog now.
        remove_leftovers(self.path)
        write(catalog, self.path, follow=True)
        return catalog
