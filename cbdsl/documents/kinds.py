"""Kinds of documents by name: each is imported when it is asked for."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any, get_args

from cbdsl.documents.document import Document
from cbdsl.documents.kind import Kind
from cbdsl.types.registry import PluginError, Registry

if TYPE_CHECKING:
    from cbdsl.diagnostics.entry import Entry


def _record(name: str, record: Any) -> Kind:
    """Return the record of a kind for readers and checkers."""
    if not isinstance(record, Kind):
        raise PluginError(f"is {type(record).__name__}, not cbdsl.extend.document.Kind")
    if not (isinstance(record.model, type) and issubclass(record.model, Document)):
        raise PluginError("its model is not a subclass of cbdsl.extend.document.Document")
    if "kind" not in record.model.model_fields or kind_name(record.model) != name:
        raise PluginError(f'its model lacks kind: Literal["{name}"]')
    if missing := record.references.keys() - record.model.model_fields:
        raise PluginError(f"its model lacks the references {', '.join(sorted(missing))}")
    if unknown := [kind for kind in record.references.values() if kind not in KINDS]:
        raise PluginError(f"it refers to kinds that are not there: {', '.join(unknown)}")
    if taken := _taken(record.entries):
        raise PluginError(f"its findings have codes of the catalogue: {', '.join(taken)}")
    folder = PurePosixPath(record.folder)
    if folder.is_absolute() or ".." in folder.parts:
        raise PluginError(f"its folder {folder} is not below a root")
    if not all(record.checker.partition(":")):
        raise PluginError(f"its checker '{record.checker}' is not module:function")
    if record.resources and not all(record.resources.partition(":")):
        raise PluginError(f"its resources '{record.resources}' are not module:function")
    return record


def _taken(entries: tuple[Entry, ...]) -> list[str]:
    if not entries:
        return []
    from cbdsl.diagnostics.catalogue import hundred  # only a fault and other packages need it

    return [entry.code for entry in entries if entry.code in hundred(entry.code)]


# Entries are places of modules, so that a model is imported when its kind is first requested.
KINDS: Registry[Kind] = Registry(
    "kind of document",
    "cbdsl.documents",
    {
        "robot": "cbdsl.documents.robot:ROBOT",
        "program": "cbdsl.documents.program:PROGRAM",
        "shared": "cbdsl.documents.shared:SHARED",
        "stage": "cbdsl.documents.stage:STAGE",
        "policy": "cbdsl.documents.policy:POLICY",
        "model": "cbdsl.documents.model:MODEL",
        "schema": "cbdsl.documents.schema:SCHEMA",
        "catalog": "cbdsl.documents.catalog:CATALOG",
        "meta_catalog": "cbdsl.documents.meta_catalog:META_CATALOG",
        "relations": "cbdsl.documents.relations:RELATIONS",
        "calibration": "cbdsl.documents.calibration:CALIBRATION",
    },
    _record,
    providers={"network": "cbdsl[onnx]"},
)


def kind_name(model: type[Document]) -> str:
    """Return the value of ``kind:`` in documents of a model."""
    return str(get_args(model.model_fields["kind"].annotation)[0])


def kind_of(model: type[Document]) -> Kind:
    """Return the record of the kind of a model."""
    return KINDS.get(kind_name(model))


def kinds_with_resources() -> Iterator[Kind]:
    """Yield the kinds whose documents give resources to programs, built-in ones first."""
    yield KINDS.get("model")
    # Package metadata is read only if a caller goes on.
    yield from (
        kind for name, kind in KINDS.all().items() if kind.resources and not KINDS.is_builtin(name)
    )


def models() -> dict[str, type[Document]]:
    """Return the models of all available kinds, by name."""
    return {name: kind.model for name, kind in KINDS.all().items()}


def entries() -> dict[str, Entry]:
    """Return the diagnostics of the catalogue and of kinds of other packages, by code."""
    from cbdsl.diagnostics.catalogue import catalogue  # only a fault needs it

    added = (entry for kind in KINDS.all().values() for entry in kind.entries)
    return catalogue() | {entry.code: entry for entry in added}


def entry_of(code: str) -> Entry | None:
    """Return the diagnostic of a code; plug-ins are read only if the catalogue lacks it."""
    from cbdsl.diagnostics.catalogue import hundred

    return hundred(code).get(code) or entries().get(code)
