"""Provenance of catalogs and meta-catalogs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Protocol

from pydantic import BaseModel

from cbdsl.documents.catalog import CatalogProvenance, JoinedActions
from cbdsl.documents.document import Document
from cbdsl.documents.document_digest import ProgramDigest, digest
from cbdsl.documents.policy import Identity
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.program.checked import CheckedProgram
from cbdsl.training.provenance import versions


class Explored(Protocol):
    """Program of an action or a pair, with its digest."""

    @property
    def program(self) -> CheckedProgram: ...
    @property
    def digest(self) -> ProgramDigest: ...


class Inputs(Protocol):
    """Inputs of an exploration that its provenance names."""

    @property
    def command(self) -> str: ...
    @property
    def robot(self) -> RobotDocument: ...
    @property
    def stage(self) -> StageDocument: ...
    @property
    def constants(self) -> BaseModel: ...
    @property
    def seed(self) -> int: ...
    @property
    def number(self) -> int: ...
    @property
    def backend(self) -> str: ...


def catalog_provenance(
    inputs: Inputs,
    explored: Mapping[str, Explored],
    algorithm: str,
    renderer: str,
    actions: int = 0,
    joined: Iterable[JoinedActions] = (),
) -> CatalogProvenance:
    """Return the provenance of a catalog or meta-catalog.

    Args:
        inputs: Inputs of the exploration.
        explored: Explored actions or pairs, by name.
        algorithm: Name of the algorithm.
        renderer: Name of the renderer of the images.
        actions: Number of actions taken.
        joined: Actions added later, in their order.
    """
    constants: dict[str, Any] = inputs.constants.model_dump()
    return CatalogProvenance(
        command=inputs.command,
        programs={
            name: Identity(name=each.program.name, sha256=each.digest.sha256)
            for name, each in explored.items()
        },
        policies={k: v for each in explored.values() for k, v in each.digest.policies.items()},
        shared={k: v for each in explored.values() for k, v in each.digest.shared.items()},
        robot=_identity(inputs.robot),
        stage=_identity(inputs.stage),
        algorithm=algorithm,
        constants={name: value for name, value in constants.items() if value is not None},
        seed=inputs.seed,
        trial=inputs.number,
        actions=actions,
        joined=tuple(joined),
        backend=inputs.backend,
        renderer=renderer,
        versions=versions(),
    )


def identity_of(provenance: CatalogProvenance) -> dict[str, Any]:
    """Return all inputs of the actions as JSON data; the number of actions is none of them.

    Relations name contacts after the actions, so that they are none of them either.
    """
    return provenance.model_dump(mode="json", exclude={"command", "actions", "joined", "relations"})


def _identity(document: Document) -> Identity:
    return Identity(name=document.name, sha256=digest(document))
