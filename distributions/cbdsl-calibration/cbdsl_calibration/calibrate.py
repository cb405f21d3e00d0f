"""``cbdsl_calibration.calibrate``: the poses of a robot's cameras, from a ball in its hand."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from cbdsl.extend.command import verb
from cbdsl_calibration.calibrate_request import CalibrateRequest

if TYPE_CHECKING:
    from cbdsl.api.documents import CalibrationDocument


@dataclass(frozen=True)
class CalibrationOutcome:
    """Written calibration.

    Attributes:
        calibration: File of the calibration, for ``load(..., calibration=...)``.
        picture: File of a picture of the views.
        document: Correction of each camera: position, m, rotation vector, rad, shape (3,) each,
            with deviations and errors in pixels.
    """

    calibration: Path
    picture: Path
    document: CalibrationDocument


@verb(CalibrateRequest)
def calibrate(request: CalibrateRequest) -> CalibrationOutcome:
    """Estimate the poses of a robot's cameras from views of a ball in its hand.

    The observations are kept beside ``out`` until it is written; after an interruption, the same
    call continues with them.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: An item is missing, not installed or unsuitable, or the views do not suffice.
        OSError: A file cannot be written.
    """
    from cbdsl import open_robot

    made = request.calibration()
    with (
        open_robot(made.run, backend=made.origin.backend, cameras=request.cameras) as robot,
        made.open_journal() as journal,
    ):
        estimates = made.estimate(robot.backend, robot.kinematics, journal, request.on_progress)
    # The robot and the journal are closed here; writing removes the file of the journal.
    document = made.write(estimates)
    return CalibrationOutcome(made.target, made.picture, document)
