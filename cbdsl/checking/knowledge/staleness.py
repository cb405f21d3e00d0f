"""Staleness of learned documents: inputs that have changed since the learning."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from cbdsl.checking.knowledge.program_digest import (
    policy_digest,
    program_digest,
    substitute_digests,
)
from cbdsl.diagnostics.errors import DiagnosticsError, UsageError
from cbdsl.documents.catalog import CatalogDocument
from cbdsl.documents.document import Document
from cbdsl.documents.document_digest import ProgramDigest, digest
from cbdsl.documents.meta_catalog import MetaCatalogDocument
from cbdsl.documents.policy import Identity, PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.relations import RelationsDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.schema import SchemaDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.yaml_text.library import Library

# Policies come first: the other documents may depend on them, and are learned again after them.
#: Kinds of documents whose provenance names a command that learns them again.
LEARNED: tuple[type[Document], ...] = (
    PolicyDocument,
    SchemaDocument,
    RelationsDocument,
    CatalogDocument,
    MetaCatalogDocument,
)


def changed_inputs(document: Document, path: Path, library: Library) -> Iterator[str]:
    """Yield the inputs of a learned document that have changed, as text.

    Args:
        document: Learned document with its provenance.
        path: File of the document.
        library: Library that finds its inputs by name.
    """
    provenance = getattr(document, "provenance", None)
    if provenance is None:
        yield "its provenance is missing"
        return
    single, several = getattr(provenance, "program", None), getattr(provenance, "programs", {})
    shared: dict[str, None] = {}
    for identity in dict.fromkeys([single, *several.values()]):
        if not isinstance(identity, Identity):
            continue
        file = library.find(ProgramDocument, identity.name, path)
        now = None if file is None else program_digest(file, library, provenance.robot.name)
        if now is None or now.sha256 != identity.sha256:
            yield f"program {identity.name}"
            shared |= dict.fromkeys(_changed_shared(provenance.shared, now))
    yield from (f"shared {name}" for name in shared)
    if isinstance(document, SchemaDocument):
        yield from (f"program {name}" for name in changed_substitutes(document, path, library))
    yield from (f"policy {name}" for name in changed_policies(provenance, path, library))
    for relations in (getattr(provenance, key, None) for key in ("earlier", "relations")):
        if relations and _digest(RelationsDocument, relations, path, library) != relations.sha256:
            yield f"relations {relations.name}"
    yield from _changed_world(provenance, path, library)


def changed_policies(provenance: Any, path: Path, library: Library) -> Iterator[str]:
    """Yield the names of a learned document's policies that have changed since."""
    for name, sha256 in provenance.policies.items():
        file = library.find(PolicyDocument, name, path)
        if file is None or policy_digest(name, path, library) != sha256:
            yield name


def changed_substitutes(schema: SchemaDocument, path: Path, library: Library) -> Iterator[str]:
    """Yield the names of the programs in place of members of a schema that have changed since."""
    provenance, program = schema.provenance, library.find(ProgramDocument, schema.program, path)
    if provenance is not None and program is not None:
        lost = {
            name for name in provenance.programs if not library.find(ProgramDocument, name, path)
        }
        kept = {k: v for k, v in schema.allocations.items() if lost.isdisjoint(v.values())}
        now = substitute_digests(kept, program, library)
        yield from (name for name, before in provenance.programs.items() if now.get(name) != before)


def program_change(
    file: Path, robot: str, sha256: str, shared: Mapping[str, str], library: Library
) -> str:
    """Return a clause if a recorded program has changed since, or is missing; else empty.

    Args:
        file: File of the program; it may have errors now.
        robot: Robot that ran it.
        sha256: Recorded digest of the program.
        shared: Recorded digests of the shared documents that it took up, by name.
        library: Library that finds documents by name.
    """
    if not file.is_file():
        return f"{file} is not there any more"
    try:
        now = program_digest(file, library, robot)
    except (DiagnosticsError, UsageError):
        return f"{file} has changed since, and has errors now"
    if now.sha256 == sha256:
        return ""
    names = [f"shared document '{name}'" for name in _changed_shared(shared, now)]
    return f"{file} has changed since{' by ' if names else ''}{', '.join(names)}"


def _changed_shared(before: Mapping[str, str], now: ProgramDigest | None) -> list[str]:
    """Return the names of changed shared documents; none if the earlier ones are unknown."""
    after = {} if now is None else now.shared
    return [name for name in {**before, **after} if before and before.get(name) != after.get(name)]


def _changed_world(provenance: Any, path: Path, library: Library) -> Iterator[str]:
    """Yield the robot and stages of a provenance that have changed, as text."""
    robot, joined = provenance.robot, getattr(provenance, "joined", ())
    if _digest(RobotDocument, robot, path, library) != robot.sha256:
        yield f"robot {robot.name}"
    for stage in dict.fromkeys([provenance.stage, *(each.stage for each in joined)]):
        if _digest(StageDocument, stage, path, library) != stage.sha256:
            yield f"stage {stage.name}"


def _digest(kind: type[Document], identity: Identity, path: Path, library: Library) -> str | None:
    file = library.find(kind, identity.name, path)
    return None if file is None else digest(library.read(file, kind).document)
