"""Pair task: objects are brought to each other, from journal to meta-catalog (7.3)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from cbdsl.backends.backend import Backend, BackendError
from cbdsl.documents.catalog import CatalogProvenance
from cbdsl.documents.meta_catalog import (
    ImpedanceSection,
    KnownThing,
    MetaCatalogDocument,
    PairSection,
)
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.learning.catalogs.action_outcome import ACTIONS, NOOP, ActionOutcome
from cbdsl.learning.catalogs.catalog_exploration import CatalogConstants, CatalogExploration
from cbdsl.runtime.episode import EpisodeError, Runner
from cbdsl.storage.journal import Journal
from cbdsl.training.exploration.action_work import ActionWork, FinishedAction
from cbdsl.training.exploration.catalog_provenance import catalog_provenance, identity_of
from cbdsl.training.exploration.catalog_task import CatalogTask
from cbdsl.training.exploration.catalog_writing import affordance_values, step_columns
from cbdsl.training.exploration.explorable_pair import ExplorablePair
from cbdsl.training.impedance_gauge import ImpedanceGauge
from cbdsl.training.known_relations import KnownRelations, impedance_section
from cbdsl.training.task_observer import TaskObserver


class PairExploration(CatalogExploration):
    """EXPLORECATALOG over pairs, where the least-tried pairs come first.

    A pair that never stood changes no model and has no value. Without this rule, only chance would
    decide whether it is ever tried.
    """

    def choose(self, rng: np.random.Generator) -> str:
        """Return the next action (see ``Exploration.choose``)."""
        tried = {name: self.affordances[name].tried for name in self.actions if name != NOOP}
        least = min(tried.values(), default=self.constants.least)
        if least >= self.constants.least:
            return super().choose(rng)
        fewest = [name for name, count in tried.items() if count == least]
        return fewest[int(rng.integers(len(fewest)))]


@dataclass(frozen=True)
class PairTask(CatalogTask):
    """Exploration of pairs, with all its inputs.

    The experimenter shows the two requested objects in a world that is set up again. The robot is
    rewarded if its program succeeds, judged by its own signals.

    Attributes:
        pairs: Explorable pairs by name.
        things: Objects, by name.
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
        relations: Names of contacts by their impedance, if known.
    """

    pairs: Mapping[str, ExplorablePair]
    things: Mapping[str, KnownThing]
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
    relations: KnownRelations | None = None

    @property
    def number(self) -> int:
        """Number of this exploration among several with its seed."""
        return 0

    def run(
        self,
        body: Backend,
        kinematics: Kinematics,
        observer: TaskObserver[FinishedAction] | None = None,
    ) -> MetaCatalogDocument:
        """Run the remaining actions on a body, and write the meta-catalog.

        Args:
            body: Backend that acts.
            kinematics: Kinematics of the robot.
            observer: Observer of the completed actions.

        Raises:
            JournalError: If the journal belongs to another undertaking.
            OSError: If journal or meta-catalog cannot be written.
        """
        identity = identity_of(self._provenance(body.renderer, 0))
        with Journal(self.journal, identity, ACTIONS) as journal:
            work = PairWork(self, body, kinematics)
            # All knowledge follows from the outcomes in their order, so a replay restores it
            # without the robot.
            for outcome in journal.rows[: self.count]:
                work.note(outcome)
            return self.complete(work, journal.append, observer, partial(self._document, work))

    def _document(self, work: PairWork) -> MetaCatalogDocument:
        """Return the meta-catalog of all finished actions."""
        impedances, sections = self._impedances(work.finished), {}
        for key, pair in self.pairs.items():
            known = affordance_values(key, work.exploration, pair.program, pair.features)
            ends = {"upper": pair.upper, "lower": pair.lower, "relation": self.relation}
            sections[key] = PairSection(**ends, **known, impedance=impedances.get(key))
        over = (thing.meta_catalog for thing in self.things.values() if thing.meta_catalog)
        return MetaCatalogDocument(
            cbdsl=1,
            kind="meta_catalog",
            name=self.path.stem,
            robot=self.robot.name,
            things=dict(self.things),
            pairs=sections,
            over=tuple(dict.fromkeys(over)),
            steps=step_columns(work.exploration),
            provenance=self._provenance(work.renderer, len(work.finished)),
            relations=None if self.relations is None else self.relations.name,
        )

    def _provenance(self, renderer: str, actions: int) -> CatalogProvenance:
        own = catalog_provenance(self, self.pairs, "explore_pairs", renderer, actions)
        known = None if self.relations is None else self.relations.identity
        return own.model_copy(update={"relations": known})

    def _impedances(self, finished: Sequence[FinishedAction]) -> dict[str, ImpedanceSection]:
        """Return the impedance of each pair with at least one complete profile, by name."""
        tree = None if self.relations is None else self.relations.tree
        outcomes = [action.outcome for action in finished]
        profiles = {
            name: [e.profile for e in outcomes if e.action == name and e.profile.is_whole]
            for name in self.pairs
        }
        return {name: impedance_section(own, tree) for name, own in profiles.items() if own}


class PairWork(ActionWork):
    """Exploration of pairs under way.

    Args:
        task: Exploration with all its inputs.
        body: Backend that acts.
        kinematics: Kinematics of the robot.
    """

    def __init__(self, task: PairTask, body: Backend, kinematics: Kinematics) -> None:
        forms = {name: pair.forms for name, pair in task.pairs.items()}
        super().__init__(PairExploration(forms, task.constants), task, body.renderer)
        self._task, self._body, self._kinematics = task, body, kinematics
        self._runners: dict[str, Runner] = {}

    def act(self, name: str, seed: int) -> ActionOutcome:
        """Bring an object to another, and read the features of both afterwards."""
        if name == NOOP:
            return ActionOutcome(NOOP, ending="nothing was done")
        pair = self._task.pairs[name]
        if name not in self._runners:
            self._runners[name] = Runner(
                self._task.robot,
                self._kinematics,
                pair.program,
                self._body,
                observed=tuple(pair.features.values()),
            )
        runner = self._runners[name]
        gauge = ImpedanceGauge(pair.program)
        try:
            result = runner.run(self._task.stage, seed, pair.context, gauge)
        except (BackendError, EpisodeError) as error:
            return ActionOutcome(name, ending=str(error), failed=True)
        readings = {key: runner.signals.read(each) for key, each in pair.features.items()}
        return ActionOutcome(
            action=name,
            # A controller at rest far from its reference did not reach its target.
            rewarded=result.outcome == "success" and not result.far,
            features={
                key: tuple(reading.value.ravel().tolist())
                for key, reading in readings.items()
                if reading is not None
            },
            ending=result.ending,
            sim_seconds=result.sim_seconds,
            profile=gauge.finish(runner.signals),
        )
