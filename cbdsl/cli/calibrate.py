"""``cb calibrate``: estimation of camera poses from a ball in the robot's hand."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cbdsl.cli.options import BodyNumber, Cameras, Seed, With
from cbdsl.cli.simulation import BackendName

if TYPE_CHECKING:
    from collections.abc import Mapping

    from cbdsl.api.run_request import RunRequest
    from cbdsl.calibration.estimate import Estimate
    from cbdsl.documents.calibration import CalibrationDocument, CalibrationOrigin

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
    from cbdsl.cli.native_output import shown_on_failure
    from cbdsl.cli.termination import termination_interrupts
    from cbdsl.errors.errors import UsageError
    from cbdsl.yaml_text.writer import make_room

    request = _request(robot, program, stage, body, with_)
    target = out or Path("knowledge/calibrations", f"{request.robot.name}.yaml")
    _require_name(target)
    try:
        make_room(target)
    except OSError as error:
        raise UsageError(f"--out {target}: {error.strerror}") from error
    origin = _origin(context, request, target)
    journal = target.with_suffix(".jsonl")
    with shown_on_failure(), termination_interrupts():
        estimates = _estimates(request, seed, backend, cameras, journal, origin)
    document = _document(request, estimates, target.stem, origin)
    _write(document, request, estimates, target)
    journal.unlink()
    print(json.dumps(_as_json(document, target)) if as_json else _summary(document, target))


def _request(
    robot: str, program: str, stage: str | None, body: int | None, with_: list[str]
) -> RunRequest:
    """Return the request of the program that shows the ball, for an uncalibrated robot."""
    from cbdsl.api.run_request import read_request
    from cbdsl.calibration.watching import require_sight_and_touch
    from cbdsl.cli.assignments import read_assignments
    from cbdsl.cli.simulation import needing_simulation
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.errors.errors import UsageError
    from cbdsl.yaml_text.library import Library

    library = Library()
    named = library.read(library.locate(RobotDocument, robot), RobotDocument).document
    with needing_simulation():
        require_sight_and_touch(named)
    values = read_assignments(with_)
    request = read_request(program, stage, None, values, body=body, uncalibrated=True)
    if request.robot.name != named.name:
        raise UsageError(
            f"program '{program}' is for robot '{request.robot.name}', not for '{named.name}'; "
            "name one that shows a ball in its hand with --program"
        )
    disturbance = request.stage.disturbance
    if disturbance.body is None and (disturbance.camera_position or disturbance.camera_rotation):
        raise UsageError(
            f"stage '{request.stage.name}' has other cameras in each episode; --body N keeps them"
        )
    return request


def _require_name(out: Path) -> None:
    from cbdsl.documents.document import NAME_PATTERN
    from cbdsl.errors.errors import UsageError

    if out.suffix != ".yaml" or not re.match(NAME_PATTERN, out.stem):
        raise UsageError(f"--out {out}: a calibration is <name>.yaml, of letters, digits and _")


def _estimates(
    request: RunRequest,
    seed: int,
    backend: str,
    cameras: str | None,
    journal: Path,
    origin: CalibrationOrigin,
) -> Mapping[str, Estimate]:
    from cbdsl.cli.progress import Progress
    from cbdsl.cli.simulation import needing_simulation, simulation
    from cbdsl.errors.errors import UsageError

    with needing_simulation():
        from cbdsl.calibration.estimate import estimate
        from cbdsl.calibration.watch_journal import WatchJournal
        from cbdsl.calibration.watching import watch
    with (
        simulation(request, backend, cameras=cameras) as (embodied, kinematics),
        WatchJournal(journal, _identity(request, origin)) as watched,
        Progress("postures shown") as progress,
    ):
        if watched.transitions:
            print(f"goes on after {watched.transitions} postures that {journal} holds")
        views = watch(
            request.robot,
            kinematics,
            request.program,
            embodied,
            request.stage,
            seed,
            progress.note,
            watched,
        )
    try:
        return estimate(request.robot.cameras, views)
    except UsageError:
        journal.unlink()  # more of the same would not help
        raise


def _identity(request: RunRequest, origin: CalibrationOrigin) -> dict[str, Any]:
    """Return all data on which the views depend."""
    from cbdsl.checking.knowledge.digest import program_digest
    from cbdsl.documents.digest import digest

    program = program_digest(request.program_file, request.library).sha256
    return {
        "command": origin.command,
        "robot": {"name": request.robot.name, "sha256": digest(request.robot)},
        "program": {"name": request.program.name, "sha256": program},
        "stage": {"name": request.stage.name, "sha256": digest(request.stage)},
    }


def _origin(context: typer.Context, request: RunRequest, target: Path) -> CalibrationOrigin:
    from cbdsl.documents.calibration import CalibrationOrigin

    given = context.params
    words = ["cb", "calibrate", request.robot.name, "--out", target.name]
    for name in ("program", "stage", "seed", "backend", "cameras", "body"):
        if given[name] is not None:
            words += [f"--{name}", str(given[name])]
    for assignment in given["with_"]:
        words += ["--with", assignment]
    return CalibrationOrigin(
        command=shlex.join(words),
        program=request.program.name,
        stage=request.stage.name,
        seed=given["seed"],
        body=request.stage.disturbance.body,
        backend=given["backend"],
    )


def _document(
    request: RunRequest, estimates: Mapping[str, Estimate], name: str, origin: CalibrationOrigin
) -> CalibrationDocument:
    from cbdsl.documents.calibration import CalibratedCamera, CalibrationDocument

    cameras = {}
    for camera, each in estimates.items():
        position, rotation = each.deviations
        cameras[camera] = CalibratedCamera(
            position=each.correction.position,
            rotation=each.correction.rotation,
            position_deviation=round(position, 6),
            rotation_deviation=round(rotation, 6),
            views=len(each.points),
            error_before=round(each.error(each.before), 3),
            error_after=round(each.error(each.after), 3),
        )
    return CalibrationDocument(
        cbdsl=1,
        name=name,
        description=f"Where the cameras of {request.robot.name} are, by what its hand showed them.",
        kind="calibration",
        robot=request.robot.name,
        cameras=cameras,
        origin=origin,
    )


def _write(
    document: CalibrationDocument,
    request: RunRequest,
    estimates: Mapping[str, Estimate],
    target: Path,
) -> None:
    from cbdsl.reporting.calibration_svg import CalibrationPanel, calibration_svg
    from cbdsl.yaml_text.writer import write, write_text

    panels = []
    for name, each in estimates.items():
        camera = request.robot.cameras[name]
        size = camera.width, camera.height
        panels.append(CalibrationPanel(name, size, each.points, each.before, each.after))
    title = f"Cameras of {request.robot.name}, before and after calibration"
    write_text(calibration_svg(title, panels), target.with_suffix(".svg"))
    write(document, target)


def _as_json(document: CalibrationDocument, target: Path) -> dict[str, Any]:
    return {"file": str(target), **document.model_dump(mode="json", exclude={"cbdsl"})}


def _summary(document: CalibrationDocument, target: Path) -> str:
    """Return the result as text."""
    lines = []
    for name, camera in document.cameras.items():
        x, y, z = (1000 * value for value in camera.position)
        a, b, c = (57.29578 * value for value in camera.rotation)
        lines.append(
            f"  {name}: displaced by ({x:.1f}, {y:.1f}, {z:.1f}) mm and "
            f"({a:.2f}, {b:.2f}, {c:.2f}) deg, known to {1000 * camera.position_deviation:.1g} mm "
            f"and {57.29578 * camera.rotation_deviation:.1g} deg; error of {camera.views} views "
            f"{camera.error_before:.2f} px, now {camera.error_after:.2f} px"
        )
    lines.append(f"written: {target} and {target.with_suffix('.svg')}")
    return "\n".join([f"cameras of {document.robot}", *lines])
