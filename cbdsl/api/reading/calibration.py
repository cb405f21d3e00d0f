"""Calibrations for commands, and the bodies that they were made with."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.documents.calibration import CalibrationDocument
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.documents.stage import StageDocument
    from cbdsl.yaml_text.library import Library


def with_body(stage: StageDocument, body: int | None) -> StageDocument:
    """Return the stage with a numbered body, or unchanged without a number.

    Raises:
        UsageError: The stage has no camera errors, by which bodies differ.
    """
    from cbdsl.diagnostics.errors import UsageError

    if body is None:
        return stage
    disturbance = stage.disturbance
    if not (disturbance.camera_position or disturbance.camera_rotation):
        raise UsageError(
            f"body {body}: bodies differ in where their cameras are, and on stage "
            f"'{stage.name}' they are where the model has them"
        )
    changed = disturbance.model_copy(update={"body": body})
    return stage.model_copy(update={"disturbance": changed})


def read_calibration(
    name: str | None, robot: RobotDocument, beside: Path, library: Library
) -> CalibrationDocument | None:
    """Read the requested calibration, or else the robot's own, if it has one.

    Args:
        name: File or name of the calibration.
        robot: Robot with the calibrated cameras.
        beside: File of the robot.
        library: Library that finds documents by name.

    Raises:
        DiagnosticsError: The calibration has errors.
        UsageError: There is no such calibration, or it is another robot's.
    """
    from cbdsl.api.reading.clean import require_clean
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.documents.calibration import CalibrationDocument

    wanted = name or robot.calibration
    if wanted is None:
        return None
    # A robot names its calibration from its own folder, and a command from the working folder.
    file = library.find(CalibrationDocument, wanted, beside)
    file = file or library.locate(CalibrationDocument, wanted)
    require_clean(file, library)
    calibration = library.read(file, CalibrationDocument).document
    if calibration.robot != robot.name:
        raise UsageError(
            f"{file}: this calibration is of robot '{calibration.robot}', not of '{robot.name}'"
        )
    return calibration


def require_body(calibration: CalibrationDocument, stage: StageDocument) -> None:
    """Refuse a calibration if the stage shows other cameras.

    Raises:
        UsageError: The cameras differ from episode to episode, or are another body's.
    """
    from cbdsl.diagnostics.errors import UsageError

    disturbance, origin = stage.disturbance, calibration.origin
    if not (disturbance.camera_position or disturbance.camera_rotation):
        return
    # A calibration without a number, as of a real robot, is accepted for each numbered body.
    own = None if origin is None else origin.body
    if disturbance.body is None:
        hint = "a body's number keeps them" if own is None else f"it was made with body {own}"
        raise UsageError(
            f"stage '{stage.name}' has other cameras in each episode, which calibration "
            f"'{calibration.name}' cannot know: {hint}"
        )
    if own is not None and own != disturbance.body:
        raise UsageError(
            f"calibration '{calibration.name}' was made with body {own}, "
            f"and this is body {disturbance.body}"
        )
