"""A course: a trial from its journal to its knowledge, however often it is interrupted."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from cbdsl.documents.policy import Provenance
from cbdsl.training.classroom import Classroom
from cbdsl.training.journal import Journal, JournalError
from cbdsl.training.knowledge import write_knowledge
from cbdsl.training.trial import Trial

OnEpisode = Callable[[Trial, float], None]


def journal_file(path: Path) -> Path:
    """Where the episodes of the policy in ``path`` are kept."""
    return path.with_suffix(".episodes.jsonl")


def open_journal(path: Path, provenance: Provenance, *, resume: bool) -> Journal:
    """The journal of a trial whose policy goes to ``path``.

    How many episodes are asked for does not matter to those that are over.

    Raises:
        JournalError: see ``Journal``; or ``path`` holds something else.
        OSError: see ``Journal``.
    """
    if path.exists() and not journal_file(path).exists():
        raise JournalError(f"{path} is there already, and was not learned here: choose another")
    identity = provenance.model_dump(mode="json", exclude={"command", "episodes"})
    return Journal(journal_file(path), identity, resume=resume)


def follow(
    trial: Trial,
    classroom: Classroom,
    journal: Journal,
    provenance: Provenance,
    path: Path,
    on_episode: OnEpisode = lambda trial, seconds: None,
) -> list[Path]:
    """Run what episodes are left, and write down what was learned.

    Args:
        trial: from its beginning; the episodes in the journal are replayed to it.
        classroom: where the others are run.
        journal: keeps each of them as soon as it is over.
        provenance: says how many there are to be.
        path: the policy's file.
        on_episode: told after each episode, with how long it took, s.

    Returns:
        The files that were written.

    Raises:
        OSError: the journal or a document cannot be written.
    """
    for experience in journal.finished[: provenance.episodes]:
        trial.replay(experience)
    while len(trial.experiences) < provenance.episodes:
        began = time.perf_counter()
        experience = trial.run(classroom)
        seconds = time.perf_counter() - began
        journal.append(experience, seconds)
        on_episode(trial, seconds)
    return write_knowledge(trial, provenance, path)
