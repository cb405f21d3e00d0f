"""Robots and stages by file or name, checked."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.documents.stage import StageDocument


def read_robot(robot: str | Path) -> tuple[RobotDocument, Path]:
    """Read and check a robot.

    Args:
        robot: File or name.

    Returns:
        The robot, and the file of its URDF.

    Raises:
        DiagnosticsError: The document has errors.
        UsageError: There is no such robot.
    """
    from cbdsl.api.reading.clean import require_clean
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.yaml_text.library import Library

    library = Library()
    file = library.locate(RobotDocument, str(robot))
    require_clean(file, library)
    document = library.read(file, RobotDocument).document
    return document, file.parent / document.model


def read_stage(stage: str | Path | None, robot: RobotDocument) -> StageDocument:
    """Read and check a stage of a robot.

    Args:
        stage: File or name; an empty stage if ``None``.
        robot: Robot that the stage has to be for.

    Raises:
        DiagnosticsError: The document has errors.
        UsageError: There is no such stage, or it is for another robot.
    """
    from cbdsl.api.reading.clean import require_clean
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.documents.stage import StageDocument
    from cbdsl.yaml_text.library import Library

    # An empty stage still needs one context, from which each episode draws.
    if stage is None:
        head = {"cbdsl": 1, "kind": "stage", "name": "empty", "robot": robot.name}
        return StageDocument.model_validate({**head, "contexts": {"empty": {}}})
    library = Library()
    file = library.locate(StageDocument, str(stage))
    require_clean(file, library)
    document = library.read(file, StageDocument).document
    if document.robot != robot.name:
        raise UsageError(
            f"stage '{document.name}' is for robot '{document.robot}', and not for '{robot.name}'"
        )
    return document
