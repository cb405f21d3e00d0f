"""Shipped documents, for experiments; documents of the same name elsewhere do not count."""

from __future__ import annotations

from pathlib import Path

from cbdsl.documents.document import Document
from cbdsl.documents.robot import RobotDocument
from cbdsl.yaml_text.library import Library, shipped


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
        raise LookupError(f"'{name}' is not shipped")
    return file
