"""Shipped documents, for experiments; documents of the same name elsewhere do not count."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from cbdsl.documents.document import Document
from cbdsl.documents.kinds import kind_of
from cbdsl.documents.robot import RobotDocument
from cbdsl.yaml_text.library import Library, shipped

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest

D = TypeVar("D", bound=Document)


def shipped_folder() -> Path:
    """Return the folder of the shipped documents, as ``folder`` of ``cbdsl.load``."""
    return shipped()


def shipped_names(kind: type[Document]) -> list[str]:
    """Return the names of the shipped documents of a kind, in order."""
    return sorted(path.stem for path in (shipped() / kind_of(kind).folder).glob("*.yaml"))


def shipped_document(kind: type[D], name: str) -> D:
    """Return a shipped document.

    Raises:
        LookupError: The document is not shipped.
    """
    library = Library(shipped())
    return library.read(shipped_file(library, kind, name), kind).document


def shipped_path(kind: type[Document], name: str) -> Path:
    """Return the file of a shipped document.

    Raises:
        LookupError: The document is not shipped.
    """
    return shipped_file(Library(shipped()), kind, name)


def shipped_robot(name: str, library: Library | None = None) -> tuple[RobotDocument, Path]:
    """Return a shipped robot and its URDF."""
    library = library or Library(shipped())
    file = shipped_file(library, RobotDocument, name)
    robot = library.read(file, RobotDocument).document
    return robot, file.parent / robot.model


def shipped_file(library: Library, kind: type[Document], name: str) -> Path:
    """Return the file of a shipped document.

    Raises:
        LookupError: The document is not shipped.
    """
    file = library.find(kind, name)
    if file is None:
        # Unlike `UsageError`: a missing document is a fault of an experiment or of the package.
        raise LookupError(f"'{name}' is not shipped")
    return file


def shipped_program(
    name: str,
    *,
    stage: str | None = None,
    policy: str | None = None,
    schema: str | None = None,
    values: Mapping[str, str] | None = None,
) -> RunRequest:
    """Load a shipped program with shipped documents alone; see ``cbdsl.load``."""
    from cbdsl.api.load import load

    return load(
        name, stage=stage, policy=policy, schema=schema, values=values or {}, folder=shipped()
    )
