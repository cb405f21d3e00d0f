"""``cbdsl.calibrate``: the poses of a robot's cameras, from a ball in its hand."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.documents.calibration import CalibrationDocument


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


def calibrate(
    robot: str | Path,
    *,
    out: str | Path | None = None,
    program: str | Path = "show_ball",
    stage: str | Path | None = None,
    seed: int = 0,
    backend: str | None = None,
    cameras: str | None = None,
    body: int | None = None,
    values: Mapping[str, str] | None = None,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> CalibrationOutcome:
    """Estimate the poses of a robot's cameras from views of a ball in its hand.

    The observations are kept beside ``out`` until it is written; after an interruption, the same
    call continues with them.

    Args:
        robot: File or name of the robot.
        out: File for the calibration; ``knowledge/calibrations/ROBOT.yaml`` if ``None``.
        program: File or name of the program that shows a held ball to the cameras.
        stage: File or name of the stage; the program's if ``None``.
        seed: Seed of all random draws.
        backend: Name of the backend, as for ``open_robot``.
        cameras: Kind of cameras, as for ``open_robot``.
        body: Number of the simulated body, which keeps its cameras' errors.
        values: Values of the program's parameters, by name.
        on_progress: Function called with the numbers of shown and of all postures.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: An item is missing, not installed or unsuitable, or the views do not suffice.
        OSError: A file cannot be written.
    """
    from cbdsl.api.open_robot import open_robot
    from cbdsl.api.requests.calibrate_request import CalibrateRequest
    from cbdsl.backends.engines import default_engine

    request = CalibrateRequest(
        robot=str(robot),
        program=str(program),
        stage=None if stage is None else str(stage),
        out=None if out is None else Path(out),
        seed=seed,
        backend=default_engine() if backend is None else backend,
        cameras=cameras,
        body=body,
        values=dict(values or {}),
    )
    calibration = request.calibration()
    with (
        open_robot(calibration.run, backend=request.backend, cameras=cameras) as opened,
        calibration.open_journal() as journal,
    ):
        estimates = calibration.estimate(opened.backend, opened.kinematics, journal, on_progress)
    # The robot and the journal are closed here; writing removes the file of the journal.
    document = calibration.write(estimates)
    return CalibrationOutcome(calibration.target, calibration.picture, document)
