"""Exploration task: actions in one world, from the journal to the catalog (Algorithm 3)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path

from cbdsl.backends.backend import Backend
from cbdsl.documents.catalog import CatalogDocument, CatalogProvenance, JoinedActions
from cbdsl.documents.policy import Identity
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.learning.catalogs.action_outcome import NOOP, ActionOutcome, FeatureForm
from cbdsl.learning.catalogs.exploration import Exploration, ExplorationObserver
from cbdsl.learning.catalogs.exploration_constants import ExplorationConstants
from cbdsl.learning.catalogs.explorations import EXPLORATIONS
from cbdsl.program.checked import CheckedProgram
from cbdsl.storage.journal import Journal, damaged
from cbdsl.training.exploration.action_runner import ActionRunner
from cbdsl.training.exploration.action_work import ActionWork, Course, FinishedAction
from cbdsl.training.exploration.catalog_provenance import catalog_provenance, identity_of
from cbdsl.training.exploration.catalog_task import CatalogTask
from cbdsl.training.exploration.catalog_writing import catalog_document
from cbdsl.training.exploration.explorable import Explorable
from cbdsl.training.exploration.exploration_phases import (
    ActionRow,
    Joined,
    Phase,
    open_journal,
    phase,
)
from cbdsl.training.task_observer import TaskObserver


@dataclass(frozen=True)
class ExplorationTask(CatalogTask):
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

    def run(
        self,
        body: Backend,
        kinematics: Kinematics,
        observer: TaskObserver[FinishedAction] | None = None,
        watcher: ExplorationObserver | None = None,
    ) -> CatalogDocument:
        """Run the remaining actions on a body, and write the catalog.

        Args:
            body: Backend that embodies the robot.
            kinematics: Kinematics of the robot.
            observer: Observer of the completed actions.
            watcher: Observer of the exploration and its episodes, if any.

        Raises:
            JournalError: If the journal belongs to another undertaking.
            OSError: If journal or catalog cannot be written.
        """
        watcher = watcher or ExplorationObserver()
        runner = ActionRunner(
            self.robot, kinematics, body, self.stage, self.actions, self.between,
            self.constants.longest, watcher,
        )  # fmt: skip
        identity = identity_of(self._provenance(body.renderer, 0, ()))
        with open_journal(self.journal, identity, joins=self.joins) as journal:
            work = ExplorationWork(
                self._begin, self.actions, runner, journal, self, body.renderer, watcher
            )
            return self.complete(work, journal.append, observer, partial(self._document, work))

    def _begin(self, forms: Forms) -> Exploration:
        """Return the exploration before its first action."""
        exploration: Exploration = EXPLORATIONS[self.algorithm](forms, self.constants)
        return exploration

    def _document(self, work: ExplorationWork) -> CatalogDocument:
        exploration, done = work.exploration, len(work.outcomes)
        return catalog_document(
            self.path.stem,
            self.feature,
            exploration,
            work.outcomes,
            work.runner.known(list(exploration.affordances)),
            self._provenance(work.renderer, done, work.phases),
        )

    def _provenance(self, renderer: str, count: int, phases: Sequence[Phase]) -> CatalogProvenance:
        actions = {action.name: action for action in self.actions}
        joined = [_joined(before, phase) for before, phase in pairwise(phases)]
        return catalog_provenance(self, actions, self.algorithm, renderer, count, joined)


def _joined(before: Phase, phase: Phase) -> JoinedActions:
    new = tuple(name for name in phase.programs if name not in before.programs)
    return JoinedActions(
        after=phase.after, programs=new, stage=Identity.model_validate(phase.stage)
    )


Forms = dict[str, Sequence[FeatureForm]]


class ExplorationWork(ActionWork):
    """Exploration under way, replayed from its journal.

    Args:
        begin: Function that returns the exploration of actions with features of some forms.
        actions: Actions of all phases.
        runner: Runner of the actions.
        journal: Journal of the exploration.
        course: Seeds and end of the exploration.
        renderer: Name of the renderer of the images.
        observer: Observer of the exploration.

    Attributes:
        runner: Runner of the actions.
        phases: Phases that have begun.

    Raises:
        DamagedJournalError: If an action of the journal does not exist.
    """

    def __init__(
        self,
        begin: Callable[[Forms], Exploration],
        actions: Iterable[Explorable],
        runner: ActionRunner,
        journal: Journal[ActionRow],
        course: Course,
        renderer: str,
        observer: ExplorationObserver,
    ) -> None:
        self._actions, self.runner, self._observer = tuple(actions), runner, observer
        # The identity in the journal is that of the first phase; rows begin the later ones.
        self.phases = [phase(0, journal.identity)]
        super().__init__(begin(self._forms(self.phases[0])), course, renderer)
        self._replay(journal)

    def _replay(self, journal: Journal[ActionRow]) -> None:
        # Line 1 is the identity. The journal may hold more actions than are requested now; the rest
        # is ignored.
        for line, row in enumerate(journal.rows, 2):
            if isinstance(row, Joined):
                self._join(row)
            elif len(self.finished) < self._course.count:
                self._require_known(row, journal, line)
                self.note(row)
                self.runner.replay(row.action)
            else:
                return

    def _join(self, row: Joined) -> None:
        """Add the actions that join now."""
        self.phases.append(phase(len(self.finished), row.parts))
        self.exploration.add(self._forms(self.phases[-1]))

    def _forms(self, phase: Phase) -> Forms:
        return {each.name: each.forms for each in self._actions if each.name in phase.programs}

    def _require_known(self, row: ActionOutcome, journal: Journal[ActionRow], line: int) -> None:
        """Check that the actions of a row exist."""
        for name in (row.action, *row.opened):
            if name not in (NOOP, *self.exploration.affordances, *self.runner.known([name])):
                raise damaged(journal.path, line, f"unknown action '{name}'", "exploration")

    def act(self, name: str, seed: int) -> ActionOutcome:
        """Run an action; see ``ActionWork.act``."""
        self._observer.note_choice(name)
        return self.runner.run(name, list(self.exploration.affordances), seed)

    def note(self, row: ActionOutcome) -> FinishedAction:
        """Learn from an outcome, and add the actions that it opened."""
        new = self.runner.known([row.action, *row.opened])
        self.exploration.add({name: each.forms for name, each in new.items()})
        action = super().note(row)
        self._observer.note_step(self.exploration)
        return action
