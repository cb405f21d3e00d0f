"""Trial loop: from the journal to the knowledge, resumed after any interruption."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, Protocol

from cbdsl.documents.policy import Provenance
from cbdsl.learning.experience import Experience
from cbdsl.runtime.line_journal import JournalError
from cbdsl.training.episode_runner import EpisodeRunner
from cbdsl.training.journal import Journal
from cbdsl.training.knowledge import model_file, write_knowledge
from cbdsl.training.trial import Trial

# What the documents of a trial need at least, bytes.
_ROOM = 1 << 16


class TrialObserver(Protocol):
    """Observer of trials."""

    def begin(self, number: int, renderer: str, finished: Sequence[Experience]) -> None:
        """A trial begins or goes on.

        Args:
            number: of the trial.
            renderer: what makes its images.
            finished: its episodes that are over.
        """
        ...

    def note(self, number: int, experience: Experience, seconds: float) -> None:
        """An episode of trial ``number`` ended after ``seconds``."""
        ...


class NullObserver:
    """Observer that ignores everything."""

    def begin(self, number: int, renderer: str, finished: Sequence[Experience]) -> None:
        """See ``TrialObserver.begin``."""

    def note(self, number: int, experience: Experience, seconds: float) -> None:
        """See ``TrialObserver.note``."""


def journal_file(path: Path) -> Path:
    """Journal of the trial whose policy goes to ``path``."""
    return path.with_suffix(".episodes.jsonl")


def require_writable(path: Path) -> None:
    """Make the folders of a policy and its models, and check that they can be written.

    This is checked before the episodes, not after.

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
    """Check that a trial whose policy goes to ``path`` overwrites nothing unasked.

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
    """Everything that the episodes of a trial depend on, as JSON.

    How many of them are asked for does not matter to those that are over.
    """
    return provenance.model_dump(mode="json", exclude={"command", "episodes", *leave_out})


def open_journal(path: Path, provenance: Provenance) -> Journal:
    """Open the journal of the trial whose policy goes to ``path``.

    Raises:
        JournalError, OSError: see ``Journal``.
    """
    return Journal(journal_file(path), identity_of(provenance))


def run_trial(
    trial: Trial,
    runner: EpisodeRunner,
    journal: Journal,
    provenance: Provenance,
    path: Path,
    observer: TrialObserver,
) -> list[Path]:
    """Run the remaining episodes and write the knowledge.

    Args:
        trial: from its beginning; the episodes in the journal are replayed to it.
        runner: where the others are run.
        journal: keeps each of them as soon as it is over.
        provenance: says how many there are to be.
        path: the policy's file.
        observer: of its progress.

    Returns:
        The files that were written.

    Raises:
        BackendError, EpisodeError: an episode cannot be run.
        OSError: the journal or a document cannot be written.
    """
    for experience in journal.finished[: provenance.episodes]:
        trial.replay(experience)
    observer.begin(trial.number, provenance.renderer, trial.experiences)
    while len(trial.experiences) < provenance.episodes:
        began = time.perf_counter()
        experience = trial.run(runner)
        seconds = time.perf_counter() - began
        journal.append(experience, seconds)
        observer.note(trial.number, experience, seconds)
    return write_knowledge(trial, provenance, path)
