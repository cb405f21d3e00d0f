"""Kinds of documents: one record each, built in or added by other packages."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any, NamedTuple, get_args

from cbdsl.documents.calibration import CalibrationDocument
from cbdsl.documents.document import Document
from cbdsl.documents.model import ModelDocument
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.schema import SchemaDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.types.registry import PluginError, Registry

if TYPE_CHECKING:
    from cbdsl.errors.entry import Entry


class Kind(NamedTuple):
    """Everything that readers, checkers and commands know of one kind of document.

    Attributes:
        model: its keys; ``kind: Literal["<name>"]`` among them.
        folder: where documents of this kind are looked up by name, below a root.
        checker: ``module:function``, called with a ``Loaded`` document, the ``Session`` and the
            ``Findings``.
        unknown: finding for a name that no document of this kind has, filled with ``name`` and
            ``hint``: a code of the catalogue or an entry of ``entries``.
        references: kinds of the documents that top-level keys name, by key.
        stand_ins: values for required keys that are missing, so that the rest is checked.
        entries: findings of the checker that the catalogue does not have.
    """

    model: type[Document]
    folder: str
    checker: str
    unknown: str | Entry
    references: Mapping[str, str] = {}
    stand_ins: Mapping[str, Any] = {}
    entries: tuple[Entry, ...] = ()


ROBOT = Kind(
    RobotDocument,
    folder="robots",
    checker="cbdsl.checking.document:check_robot",
    unknown="CB601",
    references={"calibration": "calibration"},
    stand_ins={
        "model": "unknown",
        "base": "unknown",
        "effectors": {},
        "control": {"rate": 1, "tasks": {}},
    },
)
PROGRAM = Kind(
    ProgramDocument,
    folder="programs",
    checker="cbdsl.checking.document:check_program",
    unknown="CB604",
    references={"robot": "robot"},
    stand_ins={"robot": "unknown", "controllers": {}, "actions": ["unknown"]},
)
STAGE = Kind(
    StageDocument,
    folder="programs/stages",
    checker="cbdsl.checking.stage.stage:examine_stage",
    unknown="CB602",
    references={"robot": "robot"},
    stand_ins={"robot": "unknown", "contexts": {"unknown": {}}},
)
POLICY = Kind(
    PolicyDocument,
    folder="knowledge/policies",
    checker="cbdsl.checking.policy:examine_policy",
    unknown="CB625",
    references={"program": "program"},
    stand_ins={"program": "unknown", "predicates": [], "policy": {}},
)
MODEL = Kind(
    ModelDocument,
    folder="knowledge/models",
    checker="cbdsl.checking.knowledge.model:examine_model",
    unknown="CB632",
    references={"robot": "robot"},
    stand_ins={"robot": "unknown"},
)
SCHEMA = Kind(
    SchemaDocument,
    folder="knowledge/schemas",
    checker="cbdsl.checking.document:check_schema",
    unknown="CB641",
    references={"program": "program"},
    stand_ins={
        "program": "unknown",
        "policy": "unknown",
        "features": {"unknown": "unknown"},
        "allocations": {"unknown": {}},
        "choose": "unknown",
        "otherwise": ["unknown"],
    },
)
CALIBRATION = Kind(
    CalibrationDocument,
    folder="knowledge/calibrations",
    checker="cbdsl.checking.calibration:examine_calibration",
    unknown="CB675",
    references={"robot": "robot"},
    stand_ins={"robot": "unknown", "cameras": {}},
)


def _record(name: str, record: Any) -> Kind:
    """Record that readers and checkers can use."""
    if not isinstance(record, Kind):
        raise PluginError(f"is {type(record).__name__}, not cbdsl.documents.kinds.Kind")
    if not (isinstance(record.model, type) and issubclass(record.model, Document)):
        raise PluginError("its model is no subclass of cbdsl.documents.document.Document")
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
    return record


def _taken(entries: tuple[Entry, ...]) -> list[str]:
    if not entries:
        return []
    from cbdsl.errors.catalogue import hundred  # only a fault and other packages need it

    return [entry.code for entry in entries if entry.code in hundred(entry.code)]


KINDS: Registry[Kind] = Registry(
    "kind of document",
    "cbdsl.documents",
    {
        "robot": f"{__name__}:ROBOT",
        "program": f"{__name__}:PROGRAM",
        "stage": f"{__name__}:STAGE",
        "policy": f"{__name__}:POLICY",
        "model": f"{__name__}:MODEL",
        "schema": f"{__name__}:SCHEMA",
        "calibration": f"{__name__}:CALIBRATION",
    },
    _record,
)


def kind_name(model: type[Document]) -> str:
    """Value of ``kind:`` in documents of a model."""
    return str(get_args(model.model_fields["kind"].annotation)[0])


def kind_of(model: type[Document]) -> Kind:
    """Record of the kind that has a model."""
    return KINDS.get(kind_name(model))


def models() -> dict[str, type[Document]]:
    """Models of all kinds that can be used, by name."""
    return {name: kind.model for name, kind in KINDS.all().items()}


def entries() -> dict[str, Entry]:
    """Findings by code: the catalogue, and those that kinds of other packages add."""
    from cbdsl.errors.catalogue import catalogue  # only a fault needs it

    added = (entry for kind in KINDS.all().values() for entry in kind.entries)
    return catalogue() | {entry.code: entry for entry in added}


def entry_of(code: str) -> Entry | None:
    """Finding with a code; package metadata are read only where the catalogue lacks it."""
    from cbdsl.errors.catalogue import hundred

    return hundred(code).get(code) or entries().get(code)
