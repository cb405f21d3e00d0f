"""Pair task: things are brought to each other, from the journal to the meta-catalog (7.3)."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cbdsl.backends.backend import Backend, BackendError
from cbdsl.documents.catalog import CatalogProvenance
from cbdsl.documents.meta_catalog import MetaCatalogDocument
from cbdsl.documents.policy import Identity
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.learning.action_outcome import NOOP, ActionOutcome
from cbdsl.learning.catalog_exploration import CatalogConstants
from cbdsl.learning.exploration import ExplorationStep
from cbdsl.learning.pair_exploration import PairExploration
from cbdsl.runtime.episode import EpisodeError, Runner
from cbdsl.runtime.line_journal import LineJournal
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.training.explorable_pair import ExplorablePair
from cbdsl.training.exploration_task import (
    ExplorationObserver,
    exploration_journal,
    identity_of,
    outcome_of,
    require_writable,
)
from cbdsl.training.meta_catalog_writing import meta_catalog_document
from cbdsl.training.provenance import versions
from cbdsl.yaml_text.writer import remove_leftovers, write

#: What an action's seed is used for besides the episode.
_CHOICE = 2


@dataclass(frozen=True)
class PairTask:
    """Exploration of pairs, with everything it needs.

    The experimenter shows the two things that were asked for, in a world that is set up anew. The
    robot is rewarded where its program succeeds, of which it judges by its own signals.

    Attributes:
        pairs: by name.
        things: channels of the things, by name.
        relation: what the program brings about, ``on`` or ``in``.
        robot: what acts.
        stage: who is shown what, where.
        backend: name of what embodies the robot.
        constants: of the exploration.
        seed: of all chance.
        count: how many actions at most.
        until_habituated: whether it ends before, when all models have habituated.
        command: what explores it again.
        path: the meta-catalog's file.
    """

    pairs: Mapping[str, ExplorablePair]
    things: Mapping[str, str]
    relation: str
    robot: RobotDocument
    stage: StageDocument
    backend: str
    constants: CatalogConstants
    seed: int
    count: int
    until_habituated: bool
    command: str
    path: Path

    @property
    def journal(self) -> Path:
        """File of its actions, each as soon as it is over."""
        return exploration_journal(self.path)

    def require_ready(self, *, resume: bool) -> None:
        """Check, before anything moves, that the outcome can be written.

        Raises:
            JournalError: something is in the way.
            OSError: nothing can be written there.
        """
        require_writable(self.path, self.journal, resume=resume)

    def run(
        self,
        body: Backend,
        kinematics: Callable[[], Kinematics],
        observer: ExplorationObserver = lambda number, step, outcome, seconds: None,
    ) -> MetaCatalogDocument:
        """Carry out the remaining actions on a body, and write the meta-catalog.

        Args:
            body: that acts.
            kinematics: makes the robot's.
            observer: is told of each action.

        Raises:
            JournalError: the journal is of something else.
            OSError: journal or meta-catalog cannot be written.
        """
        exploration = PairExploration({n: e.forms for n, e in self.pairs.items()}, self.constants)
        runners: dict[str, Runner] = {}
        outcomes: list[ActionOutcome] = []
        identity = self._provenance(body.renderer, 0).model_dump(
            mode="json", exclude={"command", "actions"}
        )
        with LineJournal(self.journal, identity, "exploration") as journal:
            for line, row in enumerate(journal.rows[: self.count], 2):
                outcomes.append(outcome_of(row, journal.path, line))
                exploration.note(outcomes[-1])
            while len(outcomes) < self.count:
                if self.until_habituated and exploration.is_over:
                    break
                began, seed = time.perf_counter(), self._seed(len(outcomes))
                name = exploration.choose(np.random.default_rng([seed, _CHOICE]))
                if name != NOOP and name not in runners:
                    runners[name] = self._runner(self.pairs[name], kinematics(), body)
                outcome = self._act(name, runners, seed)
                seconds = time.perf_counter() - began
                journal.append_row({**outcome._asdict(), "wall_seconds": round(seconds, 3)})
                outcomes.append(outcome)
                step: ExplorationStep = exploration.note(outcome)
                observer(len(outcomes), step, outcome, seconds)
            document = meta_catalog_document(
                self.path.stem,
                self.things,
                self.relation,
                self.pairs,
                exploration,
                self._provenance(body.renderer, len(outcomes)),
            )
            remove_leftovers(self.path)
            write(document, self.path)
        return document

    def _runner(self, pair: ExplorablePair, kinematics: Kinematics, body: Backend) -> Runner:
        observed = tuple(pair.features.values())
        return Runner(self.robot, kinematics, pair.program, body, observed=observed)

    def _act(self, name: str, runners: Mapping[str, Runner], seed: int) -> ActionOutcome:
        """Bring a thing to another one, and look at both once that is over."""
        if name == NOOP:
            return ActionOutcome(NOOP, ending="nothing was done")
        pair, runner = self.pairs[name], runners[name]
        try:
            result = runner.run(self.stage, seed, pair.context)
        except (BackendError, EpisodeError) as error:
            return ActionOutcome(name, ending=str(error), failed=True)
        seen = {key: runner.signals.read(each) for key, each in pair.features.items()}
        return ActionOutcome(
            action=name,
            # What came to rest far from its reference did not come where it was to be.
            rewarded=result.outcome == "success" and not result.far,
            features={
                key: tuple(reading.value.ravel().tolist())
                for key, reading in seen.items()
                if reading is not None
            },
            ending=result.ending,
            sim_seconds=result.sim_seconds,
        )

    def _seed(self, number: int) -> int:
        return int(np.random.SeedSequence([self.seed, 0, number]).generate_state(1)[0])

    def _provenance(self, renderer: str, actions: int) -> CatalogProvenance:
        constants: dict[str, Any] = self.constants.model_dump()
        digests = [each.digest for each in self.pairs.values()]
        policies = {name: sha for each in digests for name, sha in each.policies.items()}
        return CatalogProvenance(
            command=self.command,
            programs={
                name: Identity(name=each.program.name, sha256=each.digest.sha256)
                for name, each in self.pairs.items()
            },
            policies=policies,
            robot=identity_of(self.robot),
            stage=identity_of(self.stage),
            algorithm="explore_pairs",
            constants={name: value for name, value in constants.items() if value is not None},
            seed=self.seed,
            actions=actions,
            backend=self.backend,
            renderer=renderer,
            versions=versions(),
        )
