"""What a trial learned, as documents: a policy, and the internal models beside it."""

from __future__ import annotations

from pathlib import Path

from cbdsl.documents.document import Document
from cbdsl.documents.model import ModelDocument
from cbdsl.documents.policy import Curve, PolicyDocument, Provenance
from cbdsl.training.trial import Trial
from cbdsl.yaml_text.writer import remove_leftovers, write

# Of learned values; what lies beyond says nothing.
_DECIMALS = 6


def model_file(path: Path, effector: str) -> Path:
    """Where the internal model of an effector goes that was learned with the policy in ``path``.

    That is beside the policy, or where a library has its models: in ``models`` beside ``policies``.
    """
    folder = path.parent
    models = folder.with_name("models") if folder.name == "policies" else folder
    return models / f"{path.stem}_{effector}.yaml"


def write_knowledge(trial: Trial, provenance: Provenance, path: Path) -> list[Path]:
    """Write what was learned, models before the policy that names them.

    Nobody else may be at it, which the trial's journal sees to.

    Args:
        trial: at its end.
        provenance: where the knowledge comes from.
        path: the policy's file; its stem is the policy's name.

    Returns:
        The files, the policy's last.

    Raises:
        OSError: one cannot be written; no file is ever half written.
    """
    name = path.stem
    written = []
    documents: list[tuple[Path, Document]] = [
        (model_file(path, effector), model)
        for effector, model in model_documents(trial, name).items()
    ]
    for file, document in (*documents, (path, policy_document(trial, provenance, name))):
        file.parent.mkdir(exist_ok=True)
        remove_leftovers(file)
        write(document, file)
        written.append(file)
    return written


def model_documents(trial: Trial, name: str) -> dict[str, ModelDocument]:
    """By effector, where it was rewarded: Pr(tau | sigma, reward), named ``<name>_<effector>``."""
    return {
        effector: ModelDocument(
            cbdsl=1,
            kind="model",
            name=f"{name}_{effector}",
            description=f"Where {effector} was when {trial.program.name} was rewarded.",
            robot=trial.program.robot,
            effector=effector,
            density=density,
        )
        for effector, density in trial.learner.densities().items()
    }


def policy_document(trial: Trial, provenance: Provenance, name: str) -> PolicyDocument:
    """The greedy policy over the observed states, and all that it was learned from."""
    learner, program = trial.learner, trial.program
    return PolicyDocument(
        cbdsl=1,
        kind="policy",
        name=name,
        description="Learned by ACCOMMODATE; provenance says from what, and how to learn it again.",
        program=program.name,
        predicates=program.members,
        policy=learner.greedy(),
        models={model: f"{name}_{effector}" for model, effector in trial.learned_models().items()},
        values={
            state: {action: round(value, _DECIMALS) for action, value in values.items()}
            for state, values in learner.values.items()
        },
        transitions=dict(learner.counts.items()),
        curve=_curve(trial),
        provenance=provenance,
    )


def _curve(trial: Trial) -> Curve:
    experiences = trial.experiences
    return Curve(
        context=tuple(each.context for each in experiences),
        reward=tuple(each.reward for each in experiences),
        transitions=tuple(len(each.transitions) for each in experiences),
        ticks=tuple(each.ticks for each in experiences),
    )
