"""Exploration of actions in one world, which other actions may join."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from cbdsl.learning.catalogs.action_outcome import NOOP, ActionOutcome, FeatureForm
from cbdsl.learning.catalogs.exploration import Exploration, ExplorationObserver
from cbdsl.storage.journal import Journal, damaged
from cbdsl.training.exploration.action_runner import ActionRunner
from cbdsl.training.exploration.action_work import ActionWork, Course, FinishedAction
from cbdsl.training.exploration.explorable import Explorable
from cbdsl.training.exploration.exploration_phases import ActionRow, Joined, Phase, phase

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
