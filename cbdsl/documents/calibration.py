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
    """Displacement of one camera, with its uncertainty."""

    position_deviation: Size
    """Standard deviation of the position along its least certain direction."""
    rotation_deviation: Angle
    """Standard deviation of the rotation about its least certain axis."""
    views: PositiveCount
    """Number of views in the estimate."""
    error_before: Pixels
    """Root mean square distance between seen and expected image points, px, without calibration."""
    error_after: Pixels
    """The same distance with the calibration, px, in views that the estimate did not use."""


class CalibrationOrigin(Section):
    """Circumstances of a calibration."""

    command: str
    """Command that repeats the calibration."""
    program: Name
    """Program that showed the hand to the cameras."""
    stage: Name
    """Stage of the program."""
    seed: Count
    """Seed of all random numbers."""
    body: Count | None = None
    """Number of the simulated body that has these cameras."""
    backend: str
    """Backend of the robot."""


class CalibrationDocument(Document):
    """Displacements of a robot's cameras from their places in its model."""

    kind: Literal["calibration"]
    """Kind of this document: a calibration."""
    robot: Name
    """Robot whose cameras were calibrated."""
    cameras: Annotated[dict[Name, CalibratedCamera], Field(min_length=1)]
    """Displacement of each camera, by its name in the robot document."""
    origin: CalibrationOrigin | None = None


def with_corrections(robot: RobotDocument, known: Mapping[str, Correction]) -> RobotDocument:
    """Return a robot with the given corrections of its cameras."""
    # A camera without a known correction ends without any, even if the robot document has one.
    cameras = {
        name: camera.model_copy(update={"correction": known.get(name)})
        for name, camera in robot.cameras.items()
    }
    return robot.model_copy(update={"cameras": cameras})


def calibrated(robot: RobotDocument, calibration: CalibrationDocument) -> RobotDocument:
    """Return a robot with its cameras corrected by a calibration."""
    # Deviations and errors describe the estimate. Only its position and rotation move a camera.
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
