"""Digests of programs and of all documents that they use."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.document import Document
from cbdsl.documents.document_digest import ProgramDigest, digest
from cbdsl.documents.kinds import kind_name
from cbdsl.documents.model import ModelDocument
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.shared import SharedDocument
from cbdsl.program.steps import compiled
from cbdsl.storage.digest import digest_of_text
from cbdsl.yaml_text.library import Library
from cbdsl.yaml_text.reader import flawless

if TYPE_CHECKING:
    from cbdsl.checking.session import Session
    from cbdsl.documents.schema import SchemaDocument

# Excluded keys of the program itself: the learned policy replaces its policy, and holds on any
# stage, for the resources that it was learned with.
_BESIDE_THE_POINT = ("policy", "stage", "resources")
# Excluded keys of a learned policy: the history of its learning.
_HISTORY = ("values", "transitions", "curve", "provenance")


class _Bound:
    """Reader of programs with a robot in their roles: such a program is that of its robot.

    Args:
        library: Library that finds documents by name.
        robot: Robot of programs with roles; the first one that fits if empty.
    """

    def __init__(self, library: Library, robot: str = "") -> None:
        self.library, self._robot = library, robot
        self._session: Session | None = None
        self.shared: dict[str, str] = {}

    def program(self, path: Path) -> ProgramDocument:
        """Return a program with its policy over states, so that knowledge outlives its notation."""
        loaded = flawless(self.library.read_as_written(path, ProgramDocument))
        if loaded.document.roles:
            from cbdsl.checking.roles import without_roles  # programs of one robot do without
            from cbdsl.checking.session import Session

            self._session = self._session or Session(self.library)
            loaded = without_roles(loaded, self._robot, self._session)
        for name in loaded.document.shared:
            file = _document_file(SharedDocument, name, path, self.library)
            self.shared[name] = digest(self.library.read(file, SharedDocument).document)
        self._robot = self._robot or loaded.document.robot
        return compiled(loaded.document)


# The digest of a program includes those of all documents that it uses, as in a Merkle tree. The
# recursion ends, because programs without diagnostics do not use each other in a circle.
def program_digest(path: Path, library: Library, robot: str = "") -> ProgramDigest:
    """Return the digest of a program with all documents that it uses.

    Args:
        path: File of a program without diagnostics.
        library: Library that finds documents by name.
        robot: Robot in the roles of the program; the first one that fits if empty.
    """
    reader = _Bound(library, robot)
    document = reader.program(path)
    whole = digest(document, _BESIDE_THE_POINT) + _parts(document, path, reader)
    policies = {
        name: policy_digest(name, path, library)
        for name in sorted(_policies(document, path, reader))
    }
    return ProgramDigest(digest_of_text(whole), policies, {}, dict(sorted(reader.shared.items())))


def policy_digest(name: str, beside: Path, library: Library) -> str:
    """Return the SHA-256 of a learned policy's behaviour, with the models that belong to it.

    Args:
        name: Name of the policy.
        beside: Document that names it.
        library: Library that finds it by name.
    """
    return digest_of_text(_learned(name, beside, library))


def substitute_digests(
    allocations: Mapping[str, Mapping[str, str]], path: Path, library: Library
) -> dict[str, str]:
    """Return the SHA-256 of each program that an allocation names, with all that it uses, by name.

    Args:
        allocations: Values of a program's parameters, and programs that replace it or its members,
            by name of the allocation.
        path: File of the program that is replaced in whole or in part.
        library: Library that finds programs by name.
    """
    known = library.read(path, ProgramDocument).document.assignable
    names = {
        value
        for values in allocations.values()
        for key, value in values.items()
        if key not in known
    }
    reader = _Bound(library)
    return {name: digest_of_text(_whole(name, "", path, reader)) for name in sorted(names)}


def _policies(document: ProgramDocument, path: Path, reader: _Bound) -> Iterator[str]:
    """Yield the names of the learned policies of a program and of the programs that it uses."""
    for use in document.use.values():
        if use.schema_ is not None:
            yield _read_schema(use.schema_, path, reader.library).policy
        elif use.policy is not None:
            yield use.policy
        used = _document_file(ProgramDocument, use.program, path, reader.library)
        yield from _policies(reader.program(used), used, reader)


def _parts(document: ProgramDocument, path: Path, reader: _Bound) -> str:
    library = reader.library
    plain = [use for use in document.use.values() if use.schema_ is None]
    used = sorted({(use.program, use.policy or "") for use in plain})
    programs = (_whole(program, policy, path, reader) for program, policy in used)
    named = sorted({(u.program, u.schema_) for u in document.use.values() if u.schema_ is not None})
    schemas = (_allocated(program, schema, path, reader) for program, schema in named)
    models = (_model(name, path, library) for name in sorted(set(document.models.values())))
    return "".join((*programs, *schemas, *models, _pairs(document.meta_catalog, path, library)))


def _model(name: str, beside: Path, library: Library) -> str:
    """Return the digest of a model that a program draws from or follows."""
    kind = library.model_kind(name, beside)
    model = ModelDocument if kind is None else kind.model
    return digest(library.read(_document_file(model, name, beside, library), model).document)


def _pairs(name: str | None, beside: Path, library: Library) -> str:
    """Return the digest of the pairs that a program recognises; empty if it recognises none."""
    if name is None:
        return ""
    from cbdsl.documents.meta_catalog import MetaCatalogDocument  # few programs use one

    path = _document_file(MetaCatalogDocument, name, beside, library)
    return digest(library.read(path, MetaCatalogDocument).document, ("steps", "provenance"))


def _allocated(program: str, name: str, beside: Path, reader: _Bound) -> str:
    """Return the digest of a used program with its allocating schema and the schema's policy."""
    schema = _read_schema(name, beside, reader.library)
    models = "".join(_model(each, beside, reader.library) for each in schema.models.values())
    return digest(schema, _HISTORY) + models + _whole(program, schema.policy, beside, reader)


def _read_schema(name: str, beside: Path, library: Library) -> SchemaDocument:
    from cbdsl.documents.schema import SchemaDocument  # few programs use one

    path = _document_file(SchemaDocument, name, beside, library)
    return library.read(path, SchemaDocument).document


def _whole(program: str, policy: str, beside: Path, reader: _Bound) -> str:
    """Return the digest of a used program with its policy, which is its own or another."""
    path = _document_file(ProgramDocument, program, beside, reader.library)
    document = reader.program(path)
    own = digest(document, _BESIDE_THE_POINT if policy else ("stage", "resources"))
    return (
        own
        + (_learned(policy, beside, reader.library) if policy else "")
        + _parts(document, path, reader)
    )


def _learned(name: str, beside: Path, library: Library) -> str:
    """Return the digest of a policy with the models that belong to it."""
    path = _document_file(PolicyDocument, name, beside, library)
    document = library.read(path, PolicyDocument).document
    models = (
        library.read(_document_file(ModelDocument, model, path, library), ModelDocument)
        for _, model in sorted(document.models.items())
    )
    return "".join((digest(document, _HISTORY), *(digest(each.document) for each in models)))


def _document_file(kind: type[Document], name: str, beside: Path, library: Library) -> Path:
    path = library.find(kind, name, beside)
    if path is None:  # a program without diagnostics names documents that exist
        raise UsageError.unknown(kind_name(kind), name, library.names(kind, beside))
    return path
