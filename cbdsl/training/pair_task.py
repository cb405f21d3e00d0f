"""Pair task: objects are brought to each other, from journal to meta-catalog (7.3)."""

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
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.learning.action_outcome import NOOP, ActionOutcome
from cbdsl.learning.catalog_exploration import CatalogConstants
from cbdsl.learning.exploration import ExplorationStep
from cbdsl.learning.pair_exploration import PairExploration
from cbdsl.runtime.episode import EpisodeError, Runner
from cbdsl.runtime.line_journal import LineJournal
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

#: Stream of an action's seed for choices, beside the episode's streams.
_CHOICE = 2


@dataclass(frozen=True)
class PairTask:
    """Exploration of pairs, with all its inputs.

    The experimenter shows the two requested objects in a world that is set up again. The robot is
    rewarded if its program succeeds, judged by its own signals.

    Attributes:
        pairs: Explorable pairs by name.
        things: Channels of the objects, by name.
        relation: Relation that the program brings about, ``on`` or ``in``.
        robot: Robot that acts.
        stage: Stage with the objects in its contexts.
        backend: Name of the backend.
        constants: Constants of the exploration.
        seed: Seed of all random numbers.
        count: Largest number of actions.
        until_habituated: True if it ends early when all models have habituated.
        command: Command that repeats the exploration.
        path: Path of the meta-catalog.
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
        kinematics: Callable[[], Kinematics],
        observer: ExplorationObserver = lambda number, step, outcome, seconds: None,
    ) -> MetaCatalogDocument:
        """Run the remaining actions on a body, and write the meta-catalog.

        Args:
            body: Backend that acts.
            kinematics: Function that creates the robot's kinematics.
            observer: Listener that receives each completed action.

        Raises:
            JournalError: If the journal belongs to another undertaking.
            OSError: If journal or meta-catalog cannot be written.
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
        """Bring an object to another, and read the features of both afterwards."""
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
            # A controller at rest far from its reference did not reach its target.
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
