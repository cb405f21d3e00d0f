"""Request to explore pairs: one object for ``cb explore --thing`` and ``cbdsl.explore_pairs``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, get_args

from cbdsl.api.requests.declaration import (
    BACKEND,
    CAMERAS,
    COMMAND,
    CONSTANTS,
    FOLDER,
    SEED,
    call_text,
    declaration,
    engine_of,
    given,
)

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.learning.catalogs.action_outcome import ActionOutcome
    from cbdsl.learning.catalogs.exploration import ExplorationStep
    from cbdsl.training.exploration.explorable_pair import ExplorablePair
    from cbdsl.training.exploration.pair_task import PairTask
    from cbdsl.training.known_relations import KnownRelations


@declaration
class ExplorePairsRequest:
    """Exploration of the pairs of some objects, with all its inputs."""

    program: str = given(
        "Program that brings one object to another, as ``NAME`` or ``NAME:key=value``.",
        kw_only=False,
    )
    things: Mapping[str, str] = given(
        "Channel of each object, by name. A stack has the name of its pair in a meta-catalog, and "
        "``@`` with the name of this meta-catalog instead of a channel.",
        kw_only=False,
    )
    stage: str | Path = given(
        "File or name of a stage with a context for each pair, such as ``ball_on_box``.",
        kw_only=False,
    )
    out: str | Path = given("File for the meta-catalog, ``NAME.yaml``.", kw_only=False)
    relation: str = given("Relation that the program produces, ``on`` or ``in``.", default="on")
    actions: int = given("Number of actions.", default=100, always=True)
    until_habituated: bool = given("True to end when all models have habituated.", default=False)
    seed: int = given(SEED, default=0, always=True)
    backend: str | None = given(BACKEND, default=None, always=True)
    cameras: str | None = given(CAMERAS, default=None)
    constants: Mapping[str, str | float] = given(CONSTANTS, default_factory=dict)
    relations: str | Path | None = given(
        "Relations that name the contacts that the program tests: file or name.", default=None
    )
    resume: bool = given(
        "True to continue an exploration that was begun there.", default=False, recorded=False
    )
    folder: Path | None = given(FOLDER, default=None)
    command: str = given(COMMAND, default="", recorded=False)
    on_action: Callable[[ActionOutcome, ExplorationStep], None] | None = given(
        "Function called with the outcome of each new action, and with its reward.",
        default=None,
        recorded=False,
    )

    def task(self) -> tuple[RunRequest, PairTask]:
        """Return the program of the first pair with robot and stage, and the task, ready to run.

        Raises:
            DiagnosticsError: A document has errors.
            UsageError: An item is unknown or unsuitable.
        """
        from cbdsl.api.requests.explored_pairs import read_pairs
        from cbdsl.api.requests.explored_things import read_things
        from cbdsl.diagnostics.errors import UsageError
        from cbdsl.documents.meta_catalog import KnownThing, Relation
        from cbdsl.learning.catalogs.catalog_exploration import CatalogConstants
        from cbdsl.learning.constants import read_constants
        from cbdsl.training.exploration.pair_task import PairTask

        path = Path(self.out)
        if path.suffix != ".yaml":
            raise UsageError(f"{path}: a meta-catalog is <name>.yaml")
        if self.relation not in get_args(Relation):
            raise UsageError.unknown("relation", self.relation, get_args(Relation))
        things = read_things(self.things, self.folder)
        run, pairs = read_pairs(self.program, things, self.relation, str(self.stage), self.folder)
        return run, PairTask(
            pairs=pairs,
            things={
                name: KnownThing(feature=thing.channel, meta_catalog=thing.meta_catalog or None)
                for name, thing in things.items()
            },
            relation=self.relation,
            robot=run.robot,
            stage=run.stage,
            backend=engine_of(self),
            constants=read_constants(CatalogConstants, self.constants, "explore_pairs"),
            seed=self.seed,
            count=self.actions,
            until_habituated=self.until_habituated,
            command=self.command or self._call(),
            path=path.absolute(),
            relations=self._relations(pairs, run),
        )

    def _relations(
        self, pairs: Mapping[str, ExplorablePair], run: RunRequest
    ) -> KnownRelations | None:
        """Return the relations that name contacts.

        Raises:
            DiagnosticsError: They have errors.
            UsageError: There is no such document, or the program tests nothing to name.
        """
        from cbdsl.api.reading.relations import read_relation_tree, read_relations
        from cbdsl.diagnostics.errors import UsageError
        from cbdsl.documents.document_digest import digest
        from cbdsl.documents.policy import Identity
        from cbdsl.training.impedance_gauge import ImpedanceGauge
        from cbdsl.training.known_relations import KnownRelations

        if self.relations is None:
            return None
        program = next(iter(pairs.values())).program
        # All pairs are bound to the same program, so that the first one stands for all.
        if not ImpedanceGauge(program).listens:
            raise UsageError(f"{self.relations}: '{program.name}' tests no impedance to name")
        document = read_relations(str(self.relations), run.library).document
        tree = read_relation_tree(str(self.relations), run.library)
        identity = Identity(name=document.name, sha256=digest(document))
        return KnownRelations(document.name, tree, identity)

    def _call(self) -> str:
        """Return the call in Python that repeats the exploration."""
        texts = {"stage": repr(str(self.stage)), "out": repr(Path(self.out).name)}
        return call_text("cbdsl.explore_pairs", self, **texts)
