"""``cb calibrate``: estimation of camera poses from a ball in the robot's hand."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cbdsl.extend.command import (
    Progress,
    command_text,
    grouped,
    needing_simulation,
    print_line,
    shown_on_failure,
    simulation,
    termination_interrupts,
)
from cbdsl_calibration.calibrate_request import CalibrateRequest

if TYPE_CHECKING:
    from collections.abc import Mapping

    from cbdsl.api.documents import CalibrationDocument
    from cbdsl_calibration.calibrate_request import CameraCalibration
    from cbdsl_calibration.estimate import Estimate


Json = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]


@grouped
def calibrate(context: typer.Context, *, request: CalibrateRequest, as_json: Json = False) -> None:
    """Estimate the positions of a robot's cameras from views of a ball in its hand.

    The touching fingertips locate the ball; its position in the images yields the errors of the
    cameras. cb run --calibration and the robot's key calibration use the file. After an
    interruption, the same command continues with the observations in NAME.jsonl.

    Exit 0 if the calibration was written, 1 if a document has errors, 2 if it cannot be made.
    """
    request = replace(request, command=partial(_command, context))
    with needing_simulation():
        calibration = request.calibration()
    with shown_on_failure(), termination_interrupts():
        estimates = _estimates(calibration, request.cameras)
    document, target = calibration.write(estimates), calibration.target
    print(json.dumps(_as_json(document, target)) if as_json else _summary(document, target))


def _estimates(calibration: CameraCalibration, cameras: str | None) -> Mapping[str, Estimate]:
    with (
        simulation(calibration.run, calibration.origin.backend, cameras=cameras) as (
            embodied,
            kinematics,
        ),
        calibration.open_journal() as journal,
        Progress("postures shown") as progress,
    ):
        if journal.rows:
            print_line(f"goes on after {len(journal.rows)} postures in {calibration.journal}")
        return calibration.estimate(embodied, kinematics, journal, progress.note)


def _command(context: typer.Context, robot: str, out: str) -> str:
    """Return the command that repeats the calibration."""
    # The command is a part of the journal's identity. Without a canonical spelling, the same
    # calibration would not continue its own journal.
    return command_text(context, ["cb", "calibrate", robot], CalibrateRequest, out)


def _as_json(document: CalibrationDocument, target: Path) -> dict[str, Any]:
    return {"file": str(target), **document.model_dump(mode="json", exclude={"cbdsl"})}


def _summary(document: CalibrationDocument, target: Path) -> str:
    """Return the result as text."""
    lines = []
    for name, camera in document.cameras.items():
        x, y, z = (1000 * value for value in camera.position)
        # Degrees: 1 rad is 57.29578 degrees.
        a, b, c = (57.29578 * value for value in camera.rotation)
        lines.append(
            f"  {name}: displaced by ({x:.1f}, {y:.1f}, {z:.1f}) mm and "
            f"({a:.2f}, {b:.2f}, {c:.2f}) deg, known to {1000 * camera.position_deviation:.1g} mm "
            f"and {57.29578 * camera.rotation_deviation:.1g} deg; error of {camera.views} views "
            f"{camera.error_before:.2f} px, now {camera.error_after:.2f} px"
        )
    lines.append(f"written: {target} and {target.with_suffix('.svg')}")
    return "\n".join([f"cameras of {document.robot}", *lines])
