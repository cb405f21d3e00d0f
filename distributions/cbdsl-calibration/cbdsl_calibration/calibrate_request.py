"""Request to calibrate: one object for ``cb calibrate`` and ``cbdsl_calibration.calibrate``."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cbdsl.extend.command import (
    BACKEND,
    CAMERAS,
    SEED,
    call_text,
    declaration,
    engine_of,
    given,
)

if TYPE_CHECKING:
    from cbdsl import RunRequest
    from cbdsl.api.documents import CalibrationDocument, CalibrationOrigin
    from cbdsl.extend.backend import Backend, Kinematics
    from cbdsl.extend.command import Journal
    from cbdsl_calibration.estimate import Estimate
    from cbdsl_calibration.hand_views import HandViews


@declaration
class CalibrateRequest:
    """Calibration of a robot's cameras, with all its inputs."""

    robot: str | Path = given("Robot: file or name.", kw_only=False, kind=str, flag="-")
    out: str | Path | None = given(
        "File for the calibration; ``knowledge/calibrations/ROBOT.yaml`` if ``None``.",
        default=None,
        kind=Path | None,
        help="File for the calibration, NAME.yaml; NAME.svg beside it is a picture "
        "[knowledge/calibrations/ROBOT.yaml].",
    )
    program: str | Path = given(
        "Program that shows a held ball to the cameras: file or name.",
        default="show_ball",
        always=True,
        kind=str,
    )
    stage: str | Path | None = given(
        "Stage on which the ball is handed over: file or name [the program's].",
        default=None,
        kind=str | None,
    )
    seed: int = given(SEED, default=0, always=True)
    backend: str | None = given(BACKEND, default=None, always=True)
    cameras: str | None = given(CAMERAS, default=None)
    body: int | None = given(
        "Number of the simulated body, which keeps its cameras' errors.", default=None
    )
    values: Mapping[str, str] = given(
        "Values of the program's parameters, by name.", default_factory=dict
    )
    command: Callable[[str, str], str] | None = given(
        "Command that repeats the calibration, for the document; a function of the robot's name and"
        " the name of the file.",
        default=None,
        recorded=False,
    )
    on_progress: Callable[[int, int], None] = given(
        "Function called with the numbers of shown and of all postures.",
        default_factory=lambda: lambda done, total: None,
        recorded=False,
    )

    def calibration(self) -> CameraCalibration:
        """Return the calibration, read and checked, of a robot without corrections.

        Raises:
            DiagnosticsError: A document has errors.
            UsageError: An item is unknown or unsuitable, or the file cannot be written.
        """
        from cbdsl.api.documents import CalibrationOrigin, make_room
        from cbdsl.extend.backend import UsageError

        run = self._run()
        target = Path(self.out or f"knowledge/calibrations/{run.robot.name}.yaml")
        _require_name(target)
        try:
            # Checked while nothing moves, and not when the result is there.
            make_room(target, follow=self.out is not None)
            make_room(target.with_suffix(".svg"))
        except OSError as error:
            raise UsageError(f"{target}: {error.strerror}") from error
        backend = engine_of(self)
        command = self.command or self._call
        origin = CalibrationOrigin(
            command=command(run.robot.name, target.name),
            program=run.program.name,
            stage=run.stage.name,
            seed=self.seed,
            body=run.stage.disturbance.body,
            backend=backend,
        )
        return CameraCalibration(run, target, origin, follows=self.out is not None)

    def _run(self) -> RunRequest:
        """Return the request of the program that shows the ball, for an uncalibrated robot."""
        from cbdsl.api.load import load
        from cbdsl.extend.backend import UsageError, read_robot
        from cbdsl_calibration.watching import require_sight_and_touch

        robot, _ = read_robot(self.robot)
        require_sight_and_touch(robot)
        # The errors to estimate are relative to the poses of the model. A calibration that the
        # robot already has would hide them.
        run = load(
            self.program,
            stage=self.stage,
            values=self.values,
            body=self.body,
            uncalibrated=True,
        )
        if run.robot.name != robot.name:
            raise UsageError(
                f"program '{self.program}' is for robot '{run.robot.name}', not for "
                f"'{robot.name}'; name a program that shows a ball in its hand"
            )
        # Without a number of a body, each episode draws other camera errors, which no file can
        # correct.
        disturbance = run.stage.disturbance
        if disturbance.body is None and (
            disturbance.camera_position or disturbance.camera_rotation
        ):
            raise UsageError(
                f"stage '{run.stage.name}' has other cameras in each episode; "
                "a body's number keeps them"
            )
        return run

    def _call(self, robot: str, out: str) -> str:
        """Return the call in Python that repeats the calibration."""
        return call_text("cbdsl_calibration.calibrate", self, robot=repr(robot), out=repr(out))


@dataclass(frozen=True)
class CameraCalibration:
    """Calibration of the cameras of one robot, read and checked.

    Attributes:
        run: Program that shows the ball, with its robot and its stage.
        target: File of the calibration.
        origin: Origin of the calibration, for its document.
        follows: True if the user named the file, so that a link is followed.
    """

    run: RunRequest
    target: Path
    origin: CalibrationOrigin
    follows: bool = False

    @property
    def journal(self) -> Path:
        """File of the observations, until the calibration is written."""
        return self.target.with_suffix(".jsonl")

    def open_journal(self) -> Journal[HandViews]:
        """Open the journal of the observations, with those of an interrupted run."""
        from cbdsl.extend.command import Journal
        from cbdsl_calibration.hand_views import HAND_VIEWS

        return Journal(self.journal, self._identity(), HAND_VIEWS)

    def estimate(
        self,
        backend: Backend,
        kinematics: Kinematics,
        journal: Journal[HandViews],
        progress: Callable[[int, int], None] = lambda done, total: None,
    ) -> Mapping[str, Estimate]:
        """Show the ball to the cameras, and estimate the errors of their poses.

        Args:
            backend: Backend of the robot.
            kinematics: Kinematics of the robot.
            journal: Journal that receives the observations.
            progress: Function called with the numbers of shown and of all postures.

        Returns:
            Estimate of each camera, by its name.

        Raises:
            UsageError: The observations do not determine the cameras.
        """
        from cbdsl.extend.backend import UsageError
        from cbdsl_calibration.estimate import estimate
        from cbdsl_calibration.watching import watch

        run, seed = self.run, self.origin.seed
        views = watch(
            run.robot, kinematics, run.program, backend, run.stage, seed, progress, journal
        )
        try:
            return estimate(run.robot.cameras, views)
        except UsageError:
            self.journal.unlink()  # more of the same would not help
            raise

    def write(self, estimates: Mapping[str, Estimate]) -> CalibrationDocument:
        """Write the calibration and its picture, remove the journal, and return the document."""
        from cbdsl.api.documents import write, write_text
        from cbdsl_calibration.calibration_svg import CalibrationPanel, calibration_svg

        document, robot = self._document(estimates), self.run.robot
        panels = []
        for name, each in estimates.items():
            camera = robot.cameras[name]
            size = camera.width, camera.height
            panels.append(CalibrationPanel(name, size, each.points, each.before, each.after))
        title = f"Cameras of {robot.name}, before and after calibration"
        # The journal goes last, so that an interruption loses no observation.
        write_text(calibration_svg(title, panels), self.picture)
        write(document, self.target, follow=self.follows)
        self.journal.unlink()
        return document

    @property
    def picture(self) -> Path:
        """File of the picture."""
        return self.target.with_suffix(".svg")

    def _identity(self) -> dict[str, Any]:
        """Return all data on which the views depend."""
        from cbdsl.api.documents import digest

        run = self.run
        return {
            "command": self.origin.command,
            "robot": {"name": run.robot.name, "sha256": digest(run.robot)},
            "program": {"name": run.program.name, "sha256": run.digest.sha256},
            "stage": {"name": run.stage.name, "sha256": digest(run.stage)},
        }

    def _document(self, estimates: Mapping[str, Estimate]) -> CalibrationDocument:
        from cbdsl.api.documents import CalibratedCamera, CalibrationDocument

        cameras, name = {}, self.run.robot.name
        for camera, each in estimates.items():
            position, rotation = each.deviations
            cameras[camera] = CalibratedCamera(
                position=each.correction.position,
                rotation=each.correction.rotation,
                # Six digits are micrometres and microradians.
                position_deviation=round(position, 6),
                rotation_deviation=round(rotation, 6),
                views=len(each.points),
                error_before=round(each.error(each.before), 3),
                error_after=round(each.error(each.after), 3),
            )
        return CalibrationDocument(
            cbdsl=1,
            name=self.target.stem,
            description=f"Where the cameras of {name} are, by what its hand showed them.",
            kind="calibration",
            robot=name,
            cameras=cameras,
            origin=self.origin,
        )


def _require_name(out: Path) -> None:
    from cbdsl.extend.backend import UsageError
    from cbdsl.extend.document import NAME_PATTERN

    if out.suffix != ".yaml" or not re.fullmatch(NAME_PATTERN, out.stem):
        raise UsageError(f"{out}: a calibration is <name>.yaml, of letters, digits and _")
