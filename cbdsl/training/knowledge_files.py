"""Files of the knowledge of a trial."""

from __future__ import annotations

from pathlib import Path, PurePath

from cbdsl.documents.document import Document
from cbdsl.documents.kinds import kind_of
from cbdsl.documents.model import MODEL
from cbdsl.documents.policy import POLICY, Provenance
from cbdsl.learning.learner import TrialSummary
from cbdsl.storage.atomic_file import remove_leftovers
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
