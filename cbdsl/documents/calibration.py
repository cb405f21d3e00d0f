"""The calibration document: where a robot's cameras are, as it saw by its own hand."""

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import Field

from cbdsl.documents.document import (
    Angle,
    Count,
    Document,
    Name,
    Pixels,
    PositiveCount,
    Section,
    Size,
)
from cbdsl.documents.kind import Kind
from cbdsl.documents.robot import Correction, RobotDocument


class CalibratedCamera(Correction):
    """Displacement of one camera, and how well it is known."""

    position_deviation: Size
    """Standard deviation of the position along its least certain direction."""
    rotation_deviation: Angle
    """Standard deviation of the rotation about its least certain axis."""
    views: PositiveCount
    """How many views it was estimated from."""
    error_before: Pixels
    """Root mean square distance between seen and expected image points, uncalibrated."""
    error_after: Pixels
    """The same with the calibration, in views that it was not estimated from."""


class CalibrationOrigin(Section):
    """Circumstances of a calibration."""

    command: str
    """Command that makes it again."""
    program: Name
    """Program that showed the hand."""
    stage: Name
    """Stage that it ran on."""
    seed: Count
    """Seed of all chance."""
    body: Count | None = None
    """Number of the simulated body whose cameras these are."""
    backend: str
    """Backend that embodied the robot."""


class CalibrationDocument(Document):
    """Displacements of a robot's cameras from where its model has them."""

    kind: Literal["calibration"]
    """Says that this document is a calibration."""
    robot: Name
    """Robot whose cameras were calibrated."""
    cameras: Annotated[dict[Name, CalibratedCamera], Field(min_length=1)]
    """Displacement of each camera, by its name in the robot document."""
    origin: CalibrationOrigin | None = None


def with_corrections(robot: RobotDocument, known: Mapping[str, Correction]) -> RobotDocument:
    """A robot that takes each of its cameras to be where a correction has it, if there is one."""
    cameras = {
        name: camera.model_copy(update={"correction": known.get(name)})
        for name, camera in robot.cameras.items()
    }
    return robot.model_copy(update={"cameras": cameras})


def calibrated(robot: RobotDocument, calibration: CalibrationDocument) -> RobotDocument:
    """A robot that takes its cameras to be where a calibration found them."""
    known = {
        name: Correction(position=camera.position, rotation=camera.rotation)
        for name, camera in calibration.cameras.items()
    }
    return with_corrections(robot, known)


CALIBRATION = Kind(
    CalibrationDocument,
    folder="knowledge/calibrations",
    checker="cbdsl.checking.calibration:examine_calibration",
    unknown="CB675",
    references={"robot": "robot"},
    stand_ins={"robot": "unknown", "cameras": {}},
)
