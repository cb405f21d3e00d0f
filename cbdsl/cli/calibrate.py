"""``cb calibrate``: estimation of camera poses from a ball in the robot's hand."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cbdsl.api.requests.calibrate_request import CalibrateRequest
from cbdsl.cli.arguments.assignments import read_assignments
from cbdsl.cli.arguments.command_text import option_words
from cbdsl.cli.arguments.options import BodyNumber, Cameras, Seed, With
from cbdsl.cli.episodes.simulation import BackendName, needing_simulation, simulation
from cbdsl.cli.output.progress import Progress
from cbdsl.cli.output.terminal import print_line
from cbdsl.cli.process.native_output import shown_on_failure
from cbdsl.cli.process.termination import termination_interrupts

if TYPE_CHECKING:
    from collections.abc import Mapping

    from cbdsl.api.requests.calibrate_request import CameraCalibration
    from cbdsl.calibration.estimate import Estimate
    from cbdsl.documents.calibration import CalibrationDocument


Robot = Annotated[str, typer.Argument(help="Robot: file or name.")]
Out = Annotated[
    Path | None,
    typer.Option(
        "--out",
        help="File for the calibration, NAME.yaml; NAME.svg beside it is a picture "
        "[knowledge/calibrations/ROBOT.yaml].",
    ),
]
Program = Annotated[
    str,
    typer.Option("--program", help="Program that shows a held ball to the cameras: file or name."),
]
Stage = Annotated[
    str | None,
    typer.Option(
        "--stage", help="Stage on which the ball is handed over: file or name [the program's]."
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]


def calibrate(
    context: typer.Context,
    robot: Robot,
    *,
    out: Out = None,
    program: Program = "show_ball",
    stage: Stage = None,
    seed: Seed = 0,
    backend: BackendName,
    cameras: Cameras = None,
    body: BodyNumber = None,
    with_: With = [],  # noqa: B006 (typer)
    as_json: Json = False,
) -> None:
    """Estimate the positions of a robot's cameras from views of a ball in its hand.

    The touching fingertips locate the ball; its position in the images yields the errors of the
    cameras. cb run --calibration and the robot's key calibration use the file. After an
    interruption, the same command continues with the observations in NAME.jsonl.

    Exit 0 if the calibration was written, 1 if a document has errors, 2 if it cannot be made.
    """
    request = CalibrateRequest(
        robot=robot,
        program=program,
        stage=stage,
        out=out,
        seed=seed,
        backend=backend,
        cameras=cameras,
        body=body,
        values=read_assignments(with_),
        command=lambda name, file: _command(context, name, file),
    )
    with needing_simulation():
        calibration = request.calibration()
    with shown_on_failure(), termination_interrupts():
        estimates = _estimates(calibration, cameras)
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
    options = option_words(context, ("robot", "out", "as_json"), ("program", "seed", "backend"))
    return shlex.join(["cb", "calibrate", robot, "--out", out, *options])


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
