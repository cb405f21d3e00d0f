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

# Smallest free space for the documents of a trial, bytes.
_ROOM = 1 << 16


class TrialObserver(Protocol):
    """Observer of trials."""

    def begin(self, number: int, renderer: str, finished: Sequence[Experience]) -> None:
        """Note that a trial begins or goes on.

        Args:
            number: Number of the trial.
            renderer: Name of the renderer of the images.
            finished: Experiences of its finished episodes.
        """
        ...

    def note(self, number: int, experience: Experience, seconds: float) -> None:
        """Note that an episode of trial ``number`` ended after ``seconds``."""
        ...


class NullObserver:
    """Observer that ignores all calls."""

    def begin(self, number: int, renderer: str, finished: Sequence[Experience]) -> None:
        """Ignore the begin of a trial."""

    def note(self, number: int, experience: Experience, seconds: float) -> None:
        """Ignore an episode."""


def journal_file(path: Path) -> Path:
    """Return the journal of the trial whose policy is written to ``path``."""
    return path.with_suffix(".episodes.jsonl")


def require_writable(path: Path) -> None:
    """Create the folders of a policy and its models, and check that they can be written.

    The check is made before the episodes, not after them.

    Args:
        path: Path of the policy.

    Raises:
        OSError: If the files cannot be written, or the disk is full.
    """
    for folder in (path.parent, model_file(path, "any").parent):
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(bytes(_ROOM))
            file.flush()


def require_free(path: Path, effectors: Iterable[str], *, resume: bool) -> None:
    """Check that a trial with its policy in ``path`` overwrites no file by accident.

    Args:
        path: Path of the policy.
        effectors: Effectors whose internal models may be learned, and written beside the policy.
        resume: True to continue a trial that was begun there.

    Raises:
        JournalError: If a file exists.
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
    """Return all inputs of the episodes of a trial as JSON data.

    The number of episodes is left out, because finished episodes do not depend on it.
    """
    return provenance.model_dump(mode="json", exclude={"command", "episodes", *leave_out})


def open_journal(path: Path, provenance: Provenance) -> Journal:
    """Open the journal of the trial whose policy is written to ``path``.

    Raises:
        JournalError, OSError: Errors of ``Journal``.
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
        trial: Trial without experiences; the episodes in the journal are replayed to it.
        runner: Runner of the remaining episodes.
        journal: Journal that receives each episode when it is over.
        provenance: Provenance with the number of episodes.
        path: Path of the policy.
        observer: Observer of the trial's progress.

    Returns:
        Written files.

    Raises:
        BackendError, EpisodeError: If an episode cannot be run.
        OSError: If the journal or a document cannot be written.
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
