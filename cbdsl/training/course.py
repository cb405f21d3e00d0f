"""A course: a trial from its journal to its knowledge, however often it is interrupted."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Protocol

from cbdsl.documents.policy import Provenance
from cbdsl.training.classroom import Classroom
from cbdsl.training.journal import Journal, JournalError
from cbdsl.training.knowledge import write_knowledge
from cbdsl.training.trial import Trial


class Watcher(Protocol):
    """Is told how a trial gets on."""

    def begin(self, trial: Trial, provenance: Provenance) -> None:
        """The trial begins or goes on, with the episodes that are over."""
        ...

    def note(self, trial: Trial, seconds: float) -> None:
        """Another episode is over, which took ``seconds``."""
        ...


class Nobody:
    """Watches nothing."""

    def begin(self, trial: Trial, provenance: Provenance) -> None:
        """See ``Watcher.begin``."""

    def note(self, trial: Trial, seconds: float) -> None:
        """See ``Watcher.note``."""


def journal_file(path: Path) -> Path:
    """Where the episodes of the policy in ``path`` are kept."""
    return path.with_suffix(".episodes.jsonl")


def require_free(path: Path, *, resume: bool) -> None:
    """Make sure that a trial whose policy goes to ``path`` would overwrite nothing unasked.

    Args:
        path: the policy's file.
        resume: whether to go on with a trial that was begun there.

    Raises:
        JournalError: something is there.
    """
    journal = journal_file(path)
    if journal.exists() and not resume:
        raise JournalError(
            f"{journal} is there already: go on with --resume, or choose another --out"
        )
    if path.exists() and not journal.exists():
        raise JournalError(f"{path} is there already, and was not learned here: choose another")


def open_journal(path: Path, provenance: Provenance) -> Journal:
    """The journal of a trial whose policy goes to ``path``.

    How many episodes are asked for does not matter to those that are over.

    Raises:
        JournalError, OSError: see ``Journal``.
    """
    identity = provenance.model_dump(mode="json", exclude={"command", "episodes"})
    return Journal(journal_file(path), identity)


def follow(
    trial: Trial,
    classroom: Classroom,
    journal: Journal,
    provenance: Provenance,
    path: Path,
    watcher: Watcher,
) -> list[Path]:
    """Run what episodes are left, and write down what was learned.

    Args:
        trial: from its beginning; the episodes in the journal are replayed to it.
        classroom: where the others are run.
        journal: keeps each of them as soon as it is over.
        provenance: says how many there are to be.
        path: the policy's file.
        watcher: is told how it gets on.

    Returns:
        The files that were written.

    Raises:
        BackendError, SensorError: an episode cannot be run.
        OSError: the journal or a document cannot be written.
    """
    for experience in journal.finished[: provenance.episodes]:
        trial.replay(experience)
    watcher.begin(trial, provenance)
    while len(trial.experiences) < provenance.episodes:
        began = time.perf_counter()
        experience = trial.run(classroom)
        seconds = time.perf_counter() - began
        journal.append(experience, seconds)
        watcher.note(trial, seconds)
    return write_knowledge(trial, provenance, path)
