"""A course: a trial from its journal to its knowledge, however often it is interrupted."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, Protocol

from cbdsl.documents.policy import Provenance
from cbdsl.learning.experience import Experience
from cbdsl.training.classroom import Classroom
from cbdsl.training.journal import Journal, JournalError
from cbdsl.training.knowledge import model_file, write_knowledge
from cbdsl.training.trial import Trial

# What the documents of a trial need at least, bytes.
_ROOM = 1 << 16


class Watcher(Protocol):
    """Is told how trials get on."""

    def begin(self, number: int, renderer: str, finished: Sequence[Experience]) -> None:
        """A trial begins or goes on.

        Args:
            number: of the trial.
            renderer: what makes its images.
            finished: its episodes that are over.
        """
        ...

    def note(self, number: int, experience: Experience, seconds: float) -> None:
        """Another episode of trial ``number`` is over, which took ``seconds``."""
        ...


class Nobody:
    """Watches nothing."""

    def begin(self, number: int, renderer: str, finished: Sequence[Experience]) -> None:
        """See ``Watcher.begin``."""

    def note(self, number: int, experience: Experience, seconds: float) -> None:
        """See ``Watcher.note``."""


def journal_file(path: Path) -> Path:
    """Where the episodes of the policy in ``path`` are kept."""
    return path.with_suffix(".episodes.jsonl")


def require_writable(path: Path) -> None:
    """Make the folders of a policy and its models, and find out whether they can be kept there.

    That is to be known before the episodes, not after.

    Args:
        path: the policy's file.

    Raises:
        OSError: nothing can be written there, or the disk is full.
    """
    for folder in (path.parent, model_file(path, "any").parent):
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(bytes(_ROOM))
            file.flush()


def require_free(path: Path, effectors: Iterable[str], *, resume: bool) -> None:
    """Make sure that a trial whose policy goes to ``path`` would overwrite nothing unasked.

    Args:
        path: the policy's file.
        effectors: those of which internal models may be learned, and put beside it.
        resume: whether to go on with a trial that was begun there.

    Raises:
        JournalError: something is there.
    """
    journal = journal_file(path)
    if journal.exists() and not resume:
        raise JournalError(
            f"{journal} is there already: go on with --resume, or choose another --out"
        )
    for file in (path, *(model_file(path, effector) for effector in effectors)):
        if file.is_dir() or (file.exists() and not journal.exists()):
            raise JournalError(f"{file} is there already, and was not learned here: choose another")


def identity_of(provenance: Provenance, leave_out: Iterable[str] = ()) -> dict[str, Any]:
    """All that the episodes of a trial depend on, as JSON has it.

    How many of them are asked for does not matter to those that are over.
    """
    return provenance.model_dump(mode="json", exclude={"command", "episodes", *leave_out})


def open_journal(path: Path, provenance: Provenance) -> Journal:
    """The journal of a trial whose policy goes to ``path``.

    Raises:
        JournalError, OSError: see ``Journal``.
    """
    return Journal(journal_file(path), identity_of(provenance))


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
        BackendError, EpisodeError: an episode cannot be run.
        OSError: the journal or a document cannot be written.
    """
    for experience in journal.finished[: provenance.episodes]:
        trial.replay(experience)
    watcher.begin(trial.number, provenance.renderer, trial.experiences)
    while len(trial.experiences) < provenance.episodes:
        began = time.perf_counter()
        experience = trial.run(classroom)
        seconds = time.perf_counter() - began
        journal.append(experience, seconds)
        watcher.note(trial.number, experience, seconds)
    return write_knowledge(trial, provenance, path)
