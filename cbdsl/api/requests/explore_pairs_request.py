"""Request to explore pairs: one object for ``cb explore --thing`` and ``cbdsl.explore_pairs``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, get_args

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.training.exploration.explorable_pair import ExplorablePair
    from cbdsl.training.exploration.pair_task import PairTask
    from cbdsl.training.known_relations import KnownRelations


@dataclass(frozen=True)
class ExplorePairsRequest:
    """Exploration of the pairs of some objects, with all its inputs.

    Attributes:
        program: Program that brings one object to another, as ``NAME`` or ``NAME:key=value``.
        things: Channel of each object, by name; ``@META_CATALOG`` for a stack that is named like
            its pair.
        stage: Stage with a context for each pair, such as ``ball_on_box``: file or name.
        out: File for the meta-catalog, ``NAME.yaml``.
        relation: Relation that the program brings about, ``on`` or ``in``.
        actions: Largest number of actions.
        until_habituated: True to end when all models have habituated.
        seed: Seed of all random draws.
        backend: Name of the backend; the first installed one if ``None``.
        cameras: Kind of the backend's cameras; the backend's default if ``None``.
        constants: Constants of the exploration by name, as text with units or in SI.
        folder: Folder to search for documents by name; the working folder if ``None``.
        relations: Relations that name the contacts that the program tests: file or name.
        command: Command that repeats the exploration, for the provenance of the meta-catalog.
    """

    program: str
    things: Mapping[str, str]
    stage: str
    out: Path
    relation: str = "on"
    actions: int = 100
    until_habituated: bool = False
    seed: int = 0
    backend: str | None = None
    cameras: str | None = None
    constants: Mapping[str, str | float] = field(default_factory=dict)
    folder: Path | None = None
    relations: str | None = None
    command: str = ""

    def task(self) -> tuple[RunRequest, PairTask]:
        """Return the program of the first pair with robot and stage, and the task, ready to run.

        Raises:
            DiagnosticsError: A document has errors.
            UsageError: An item is unknown or unsuitable.
        """
        from cbdsl.api.requests.explored_pairs import read_pairs
        from cbdsl.api.requests.explored_things import read_things
        from cbdsl.backends.engines import default_engine
        from cbdsl.diagnostics.errors import UsageError
        from cbdsl.documents.meta_catalog import KnownThing, Relation
        from cbdsl.learning.catalogs.catalog_exploration import CatalogConstants
        from cbdsl.learning.constants import read_constants
        from cbdsl.training.exploration.pair_task import PairTask

        if self.out.suffix != ".yaml":
            raise UsageError(f"{self.out}: a meta-catalog is <name>.yaml")
        if self.relation not in get_args(Relation):
            raise UsageError.unknown("relation", self.relation, get_args(Relation))
        things = read_things(self.things, self.folder)
        run, pairs = read_pairs(self.program, things, self.relation, self.stage, self.folder)
        return run, PairTask(
            pairs=pairs,
            things={
                name: KnownThing(feature=thing.channel, meta_catalog=thing.meta_catalog or None)
                for name, thing in things.items()
            },
            relation=self.relation,
            robot=run.robot,
            stage=run.stage,
            backend=default_engine() if self.backend is None else self.backend,
            constants=read_constants(CatalogConstants, self.constants, "explore_pairs"),
            seed=self.seed,
            count=self.actions,
            until_habituated=self.until_habituated,
            command=self.command or self._call(),
            path=self.out.absolute(),
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
        document = read_relations(self.relations, run.library).document
        tree = read_relation_tree(self.relations, run.library)
        identity = Identity(name=document.name, sha256=digest(document))
        return KnownRelations(document.name, tree, identity)

    def _call(self) -> str:
        """Return the call in Python that repeats the exploration."""
        from cbdsl.api.requests.call_text import call_text, chosen

        words = [f"{self.program!r}", f"{dict(self.things)!r}", f"{self.stage!r}"]
        names = (
            "relation", "actions", "until_habituated", "seed", "backend", "cameras", "relations",
        )  # fmt: skip
        # These are always written: the default backend depends on the installation.
        options = chosen(self, names, always=("actions", "seed", "backend"))
        if self.constants:
            options["constants"] = dict(self.constants)
        return call_text("explore_pairs", [*words, f"{self.out.name!r}"], options)
