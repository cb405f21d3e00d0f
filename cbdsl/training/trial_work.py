"""Trial under way: from the journal to the knowledge, resumed after any interruption."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePath
from typing import Any

from cbdsl.documents.document import Document
from cbdsl.documents.kinds import kind_of
from cbdsl.documents.model import MODEL
from cbdsl.documents.policy import POLICY, Provenance
from cbdsl.learning.experience import EPISODES, Experience
from cbdsl.learning.learner import TrialSummary
from cbdsl.storage.atomic_file import remove_leftovers, require_unlinked
from cbdsl.storage.journal import Journal
from cbdsl.training.episode_runner import EpisodeRunner
from cbdsl.training.task_files import require_free, require_room, trial_journal
from cbdsl.training.task_loop import run_items
from cbdsl.training.task_observer import TaskObserver
from cbdsl.training.trial import Trial
from cbdsl.yaml_text.writer import write


def model_file(path: Path, effector: str) -> Path:
    """Return the file of an effector's internal model, learned with the policy in ``path``."""
    return _beside(path, MODEL.folder, f"{path.stem}_{effector}")


def _beside(path: Path, folder: str, name: str) -> Path:
    """Return a file beside a policy, or its place in a library: ``models`` beside ``policies``."""
    own = path.parent
    is_library = own.name == PurePath(POLICY.folder).name
    return (own.with_name(PurePath(folder).name) if is_library else own) / f"{name}.yaml"


def write_knowledge(trial: Trial, provenance: Provenance, path: Path) -> list[Path]:
    """Write the documents of a trial, the policy last.

    The trial's journal prevents concurrent writers.

    Args:
        trial: Trial at its end.
        provenance: Provenance of the knowledge.
        path: Path of the policy; its stem is the policy's name.

    Returns:
        Written files, the policy's last.

    Raises:
        OSError: If a file cannot be written; no file is ever incomplete.
    """
    # The policy is last, so that an interruption leaves no new policy without its models.
    files = []
    for document in learned_documents(trial, provenance, path.stem):
        file = _beside(path, kind_of(type(document)).folder, document.name)
        file.parent.mkdir(exist_ok=True)
        remove_leftovers(file)
        write(document, file, follow=file == path)
        files.append(file)
    return files


def learned_documents(trial: Trial, provenance: Provenance, name: str) -> list[Document]:
    """Return the documents learned in a trial, the policy of the given name last."""
    models, program = trial.learned_models(), trial.program
    summary = TrialSummary(name, program, models, trial.experiences, provenance)
    return trial.learner.documents(summary)


@dataclass(frozen=True)
class TrialWork:
    """Trial under way.

    Attributes:
        trial: Trial that learns from the episodes.
        runner: Runner of the remaining episodes.
        episodes: Number of episodes.
        renderer: Name of the renderer of the images.
    """

    trial: Trial
    runner: EpisodeRunner
    episodes: int
    renderer: str

    @property
    def number(self) -> int:
        """Number of the trial."""
        return self.trial.number

    @property
    def finished(self) -> Sequence[Experience]:
        """Experiences so far."""
        return self.trial.experiences

    @property
    def is_over(self) -> bool:
        """True if no episode is left."""
        return len(self.trial.experiences) >= self.episodes

    def run_next(self) -> Experience:
        """Run the next episode."""
        return self.trial.play(self.runner)

    def note(self, row: Experience) -> Experience:
        """Learn from a new episode."""
        self.trial.remember(row)
        return row


def require_ready(path: Path, effectors: Iterable[str], *, resume: bool) -> None:
    """Check that the documents of a trial can be written, and overwrite no file by accident.

    Args:
        path: Path of the policy.
        effectors: Effectors whose internal models may be learned, and written beside the policy.
        resume: True to continue a trial that was begun there.

    Raises:
        JournalError: If a file exists.
        OSError: If the files cannot be written, or the disk is full.
    """
    models = [model_file(path, effector) for effector in effectors]
    folder = model_file(path, "any").parent
    if folder != path.parent:
        require_unlinked(folder)
    for model in models:
        require_unlinked(model)
    require_room((path.parent, folder))
    require_free(trial_journal(path), [path, *models], "learned", resume=resume)


def identity_of(provenance: Provenance, leave_out: Iterable[str] = ()) -> dict[str, Any]:
    """Return all inputs of the episodes of a trial as JSON data.

    The number of episodes is left out, because finished episodes do not depend on it.
    """
    return provenance.model_dump(mode="json", exclude={"command", "episodes", *leave_out})


def open_journal(path: Path, provenance: Provenance) -> Journal[Experience]:
    """Open the journal of the trial whose policy is written to ``path``.

    Raises:
        JournalError, OSError: Errors of ``Journal``.
    """
    return Journal(trial_journal(path), identity_of(provenance), EPISODES)


def run_trial(
    trial: Trial,
    runner: EpisodeRunner,
    journal: Journal[Experience],
    provenance: Provenance,
    path: Path,
    observer: TaskObserver[Experience],
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
    # The journal may hold more episodes than are requested now; they are not learned from.
    for experience in journal.rows[: provenance.episodes]:
        trial.replay(experience)
    work = TrialWork(trial, runner, provenance.episodes, provenance.renderer)
    run_items(work, journal.append, observer)
    return write_knowledge(trial, provenance, path)
