"""Exploration task: actions in one world, from the journal to the catalog (Algorithm 3)."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from cbdsl.backends.backend import Backend
from cbdsl.documents.catalog import CatalogDocument, CatalogProvenance, JoinedActions
from cbdsl.documents.digest import digest
from cbdsl.documents.document import Document
from cbdsl.documents.policy import Identity
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.learning.action_outcome import NOOP, ActionOutcome, FeatureForm
from cbdsl.learning.exploration import Exploration, ExplorationStep
from cbdsl.learning.exploration_constants import ExplorationConstants
from cbdsl.learning.explorations import EXPLORATIONS
from cbdsl.program.checked import CheckedProgram
from cbdsl.runtime.line_journal import JournalError, damaged
from cbdsl.training.action_runner import ActionRunner
from cbdsl.training.catalog_writing import catalog_document
from cbdsl.training.explorable import Explorable
from cbdsl.training.exploration_journal import ExplorationJournal, Phase
from cbdsl.training.exploration_watcher import ExplorationWatcher
from cbdsl.training.provenance import versions
from cbdsl.yaml_text.writer import remove_leftovers, write

# Stream of an action's seed for choices, beside the world (0) and the program's draws (1).
_CHOICE = 2

#: Listener for number of completed actions, newest step, its outcome and its wall time, s.
ExplorationObserver = Callable[[int, ExplorationStep, ActionOutcome, float], None]


@dataclass(frozen=True)
class ExplorationTask:
    """Exploration with all its inputs; it can be sent to another process.

    Attributes:
        actions: Actions that can be chosen.
        between: Program that brings the robot back after each action.
        feature: Channel of the object.
        robot: Robot that acts.
        urdf: Path of the robot's URDF model.
        stage: Stage that describes the world.
        backend: Name of the backend.
        algorithm: Algorithm, one of ``EXPLORATIONS``.
        constants: Constants of the algorithm.
        seed: Seed of all random numbers.
        number: Number of this exploration among several with this seed.
        count: Largest number of actions.
        until_habituated: True if it ends early when all models have habituated.
        command: Command that repeats the exploration.
        path: Path of the catalog.
        cameras: Kind of the backend's cameras; ``None`` for the backend's default.
        joins: True if some of the actions may join an exploration that began without them.
    """

    actions: tuple[Explorable, ...]
    between: CheckedProgram
    feature: str
    robot: RobotDocument
    urdf: Path
    stage: StageDocument
    backend: str
    algorithm: str
    constants: ExplorationConstants
    seed: int
    number: int
    count: int
    until_habituated: bool
    command: str
    path: Path
    cameras: str | None = None
    joins: bool = False

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
        require_writable(self.path, self.journal, resume=resume)

    def run(
        self,
        body: Backend,
        kinematics: Kinematics,
        observer: ExplorationObserver = lambda number, step, outcome, seconds: None,
        watcher: ExplorationWatcher | None = None,
    ) -> CatalogDocument:
        """Run the remaining actions on a body, and write the catalog.

        Args:
            body: Backend that embodies the robot.
            kinematics: Kinematics of the robot.
            observer: Listener that receives each completed action.
            watcher: Observer of the exploration and its episodes, if any.

        Raises:
            JournalError: If the journal belongs to another undertaking.
            OSError: If journal or catalog cannot be written.
        """
        runner = ActionRunner(
            self.robot,
            kinematics,
            body,
            self.stage,
            self.actions,
            self.between,
            self.constants.longest,
            watcher,
        )
        outcomes: list[ActionOutcome] = []
        identity = self._identity(body.renderer)
        with ExplorationJournal(self.journal, identity, joins=self.joins) as journal:
            exploration = self._exploration(journal.phases[0])
            for line, row in journal.rows[: self.count]:
                self._admit(exploration, journal.phases, len(outcomes))
                outcomes.append(outcome_of(row, journal.path, line))
                self._require_known(outcomes[-1], exploration, runner, journal.path, line)
                self._note(exploration, outcomes[-1], runner, watcher)
            self._admit(exploration, journal.phases, len(outcomes))
            while len(outcomes) < self.count:
                if self.until_habituated and exploration.is_over:
                    break
                began, seed = time.perf_counter(), self._seed(len(outcomes))
                name = exploration.choose(np.random.default_rng([seed, _CHOICE]))
                if watcher is not None:
                    watcher.note_choice(name)
                outcome = runner.run(name, list(exploration.affordances), seed)
                seconds = time.perf_counter() - began
                journal.append_row({**outcome._asdict(), "wall_seconds": round(seconds, 3)})
                outcomes.append(outcome)
                step = self._note(exploration, outcome, runner, watcher)
                observer(len(outcomes), step, outcome, seconds)
            phases = [each for each in journal.phases if each.after <= len(outcomes)]
            provenance = self._provenance(body.renderer, len(outcomes), phases)
            known = runner.known(list(exploration.affordances))
            document = catalog_document(
                self.path.stem, self.feature, exploration, outcomes, known, provenance
            )
            remove_leftovers(self.path)
            write(document, self.path)
        return document

    def _exploration(self, phase: Phase) -> Exploration:
        """Return the exploration before its first action."""
        made: Exploration = EXPLORATIONS[self.algorithm](self._forms(phase), self.constants)
        return made

    def _admit(self, exploration: Exploration, phases: Iterable[Phase], done: int) -> None:
        """Add the actions that join after a number of completed actions."""
        for phase in phases:
            if phase.after == done:
                exploration.add(self._forms(phase))

    def _forms(self, phase: Phase) -> dict[str, Sequence[FeatureForm]]:
        return {each.name: each.forms for each in self.actions if each.name in phase.programs}

    def _require_known(
        self,
        outcome: ActionOutcome,
        exploration: Exploration,
        runner: ActionRunner,
        path: Path,
        line: int,
    ) -> None:
        """Check that an action of a journal exists."""
        for name in (outcome.action, *outcome.opened):
            if name not in (NOOP, *exploration.affordances, *runner.known([name])):
                raise damaged(path, line, f"unknown action '{name}'", "exploration")

    def _note(
        self,
        exploration: Exploration,
        outcome: ActionOutcome,
        runner: ActionRunner,
        watcher: ExplorationWatcher | None,
    ) -> ExplorationStep:
        new = runner.known([outcome.action, *outcome.opened])
        exploration.add({name: each.forms for name, each in new.items()})
        step = exploration.note(outcome)
        if watcher is not None:
            watcher.note_step(exploration)
        return step

    def _seed(self, number: int) -> int:
        entropy = np.random.SeedSequence([self.seed, self.number, number])
        return int(entropy.generate_state(1)[0])

    def _identity(self, renderer: str) -> dict[str, Any]:
        """Return all inputs of the actions as JSON data; the number of actions is none of them."""
        leave_out = {"command", "actions", "joined"}
        provenance = self._provenance(renderer, 0, ())
        return provenance.model_dump(mode="json", exclude=leave_out)

    def _provenance(self, renderer: str, count: int, phases: Sequence[Phase]) -> CatalogProvenance:
        constants = self.constants.model_dump()
        policies = {k: v for each in self.actions for k, v in each.digest.policies.items()}
        return CatalogProvenance(
            command=self.command,
            programs={
                each.name: Identity(name=each.program.name, sha256=each.digest.sha256)
                for each in self.actions
            },
            policies=policies,
            robot=identity_of(self.robot),
            stage=identity_of(self.stage),
            algorithm=self.algorithm,
            constants={name: value for name, value in constants.items() if value is not None},
            seed=self.seed,
            trial=self.number,
            actions=count,
            joined=tuple(_joined(before, phase) for before, phase in pairwise(phases)),
            backend=self.backend,
            renderer=renderer,
            versions=versions(),
        )


def exploration_journal(path: Path) -> Path:
    """Return the file of the actions of a catalog or meta-catalog."""
    return path.with_suffix(".actions.jsonl")


def require_writable(path: Path, journal: Path, *, resume: bool) -> None:
    """Check that a catalog and the journal of its actions can be written.

    Args:
        path: Path of the catalog; its folder is created.
        journal: Path of the journal of its actions.
        resume: True if the journal may exist and is continued.

    Raises:
        JournalError: If other files are in the way.
        OSError: If the files cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    if journal.exists() and not resume:
        raise JournalError(
            f"{journal} is there already: go on with --resume, or choose another --out"
        )
    if path.is_dir() or (path.exists() and not journal.exists()):
        raise JournalError(f"{path} is there already, and was not explored here: choose another")


def _joined(before: Phase, phase: Phase) -> JoinedActions:
    new = tuple(name for name in phase.programs if name not in before.programs)
    return JoinedActions(
        after=phase.after, programs=new, stage=Identity.model_validate(phase.stage)
    )


def identity_of(document: Document) -> Identity:
    """Return name and digest of a document."""
    return Identity(name=document.name, sha256=digest(document))


def outcome_of(row: Mapping[str, Any], path: Path, line: int) -> ActionOutcome:
    """Return the outcome in a line of a journal.

    Args:
        row: Contents of the line.
        path: Path of the journal, for messages.
        line: Number of the line.

    Raises:
        JournalError: If the line holds no outcome.
    """
    try:
        ahead = {name: _tuples(own) for name, own in row["ahead"].items()}
        return ActionOutcome(
            action=_text(row["action"]),
            rewarded=bool(row["rewarded"]),
            features=_tuples(row["features"]),
            opened=tuple(map(_text, row["opened"])),
            ahead=ahead,
            ending=_text(row["ending"]),
            failed=bool(row["failed"]),
            sim_seconds=float(row["sim_seconds"]),
        )
    except KeyError as error:
        raise damaged(path, line, f"it lacks {error}", "exploration") from error
    except (TypeError, ValueError, AttributeError) as error:
        raise damaged(path, line, f"it is not an action ({error})", "exploration") from error


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{value!r} is not text")
    return value


def _tuples(values: Mapping[str, Sequence[float]]) -> dict[str, tuple[float, ...]]:
    return {name: tuple(map(float, value)) for name, value in values.items()}
