"""Request to load a program: one object for ``cbdsl.load`` and the commands that run it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from cbdsl.api.requests.declaration import FOLDER, declaration, given
from cbdsl.api.requests.run_request import RunRequest, locate, require_served, under_policy
from cbdsl.types.role import ROBOT

if TYPE_CHECKING:
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.documents.stage import StageDocument
    from cbdsl.program.checked import CheckedProgram
    from cbdsl.yaml_text.library import Library


@declaration
class LoadOptions:
    """Documents and settings with which a program is read."""

    stage: str | Path | None = given(
        "File or name of the stage to run on [the program's].",
        default=None,
        kind=str | None,
        help="Stage: file or name [the program's].",
        completes="stage",
    )
    policy: str | Path | None = given(
        "File or name of the policy that chooses its actions [the program's].",
        default=None,
        kind=str | None,
        help="Policy: file or name [the program's].",
        completes="policy",
    )
    schema: str | Path | None = given(
        "File or name of the schema that chooses its resources, with a policy of its own.",
        default=None,
        kind=str | None,
        help="Schema that chooses the resources: file or name.",
        completes="schema",
    )
    values: Mapping[str, str] = given(
        "Values of the program's parameters, by name, as written in documents.",
        default_factory=dict,
    )
    robot: str | Path | None = given(
        "Robot of a program with roles: file or name [the first one that fits].",
        default=None,
        kind=str | None,
        completes="robot",
    )
    rate: float | None = given(
        "Control rate, Hz [the robot document's].", default=None, kind=float | None
    )
    calibration: str | Path | None = given(
        "File or name of the cameras' calibration [the robot's].",
        default=None,
        kind=str | None,
        help="Calibration of the cameras: file or name [the robot's].",
    )
    body: int | None = given(
        "Number of the simulated body, which determines its camera errors [the stage's].",
        default=None,
    )
    clearance: str | None = given(
        "Least distance between the robot's links: 2cm [the program's].",
        default=None,
        kind=str | None,
    )
    uncalibrated: bool = given("True to use the camera poses of the robot's model.", default=False)
    folder: Path | None = given(FOLDER, default=None)

    def read(self, program: str | Path, given: Mapping[Path, bytes] | None = None) -> RunRequest:
        """Read and check a program and all documents that it needs to run.

        Args:
            program: File or name of the program.
            given: Contents that replace those of files.

        Raises:
            DiagnosticsError: A document has errors.
            UsageError: There is no such document, or the documents do not fit each other.
        """
        from cbdsl.api.reading.calibration import read_calibration, require_body, with_body
        from cbdsl.checking.program import check_program
        from cbdsl.diagnostics.errors import UsageError
        from cbdsl.documents.calibration import calibrated, with_corrections
        from cbdsl.documents.program import ProgramDocument
        from cbdsl.documents.robot import RobotDocument
        from cbdsl.robot.control_rate import with_control_rate
        from cbdsl.yaml_text.library import Library

        if self.policy is not None and self.schema is not None:
            raise UsageError("a schema names its policy: give policy or schema, not both")
        values = dict(self.values or {})
        if self.robot is not None and values.setdefault(ROBOT, str(self.robot)) != str(self.robot):
            raise UsageError(f"robot {self.robot}: the values name another, {values[ROBOT]}")
        library = Library(self.folder, given)
        path = library.locate(ProgramDocument, str(program))
        checked = check_program(path, values, library)
        robot_file = library.find(RobotDocument, checked.robot, path)
        assert robot_file is not None, "a checked program has a robot"
        robot = library.read(robot_file, RobotDocument).document
        learned = checked
        # A policy chooses among the actions of this program. A schema makes another program, with
        # an allocation of resources for each context.
        if self.policy is not None:
            learned = under_policy(checked, str(self.policy), path, library)
        elif self.schema is not None:
            learned = _as_schema(checked, str(self.schema), path, library, values)
        shown = with_body(
            _read_stage(_word(self.stage), checked, path, robot, robot_file, library), self.body
        )
        # Empty corrections replace those of the document, so that the cameras are as in the model.
        if self.uncalibrated:
            robot = with_corrections(robot, {})
        elif known := read_calibration(_word(self.calibration), robot, robot_file, library):
            require_body(known, shown)
            robot = calibrated(robot, known)
        urdf = robot_file.parent / robot.model
        return RunRequest(
            program=_guarded(learned, shown, robot, urdf, self.clearance),
            program_file=path,
            robot=with_control_rate(robot, self.rate),
            urdf=urdf,
            stage=shown,
            library=library,
            values=values,
        )


@declaration
class _Located:
    """File of a program."""

    program: str | Path = given("File or name of the program.", kw_only=False)


@declaration
class LoadRequest(LoadOptions, _Located):
    """Program with the documents and settings with which it is read."""


def _word(document: str | Path | None) -> str | None:
    return None if document is None else str(document)


def _guarded(
    program: CheckedProgram,
    stage: StageDocument,
    robot: RobotDocument,
    urdf: Path,
    clearance: str | None,
) -> CheckedProgram:
    """Return a program with a given clearance, and with the fixtures that matter to its links.

    Raises:
        UsageError: The clearance is not a length above 0, the stage has no such fixture, or a link
            starts too near another one or a fixture.
    """
    from cbdsl.program.checked import fixtures_of

    names = fixtures_of(program)
    if clearance is None and not names:
        return program
    from cbdsl.checking.stage.fixture_hulls import fixture_hull
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.kinematics.link_clearance import too_near_at_start, with_places
    from cbdsl.robot.urdf_reader import read_urdf

    if clearance is not None:
        least = _least_distance(clearance)
        program = program._replace(guards=program.guards._replace(clearance=least))
    hulls = {}
    for name in names:
        hull = fixture_hull(name, stage)
        if isinstance(hull, str):
            raise UsageError(f"{program.name}: {hull}")
        hulls[name] = hull
    least = program.all_guards.clearance or 0.0
    kept = {name: hulls[name] for name in program.all_guards.fixtures}
    if least and (near := too_near_at_start(with_places(robot, kept), read_urdf(urdf), least)):
        given = "" if clearance is None else f" with clearance {clearance}"
        raise UsageError(f"{program.name} on {stage.name}{given}: {near}")
    return program._replace(guards=program.guards._replace(hulls=hulls))


def _least_distance(clearance: str) -> float:
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.types.unit import QuantityError, read_quantity

    try:
        least = read_quantity(clearance, ("length",))
    except QuantityError as error:
        raise UsageError(f"clearance: {error}") from None
    if least <= 0.0:
        raise UsageError(f"clearance: {clearance} is not above 0")
    return least


def _read_stage(
    name: str | None,
    program: CheckedProgram,
    program_file: Path,
    robot: RobotDocument,
    robot_file: Path,
    library: Library,
) -> StageDocument:
    from cbdsl.api.reading.clean import require_clean
    from cbdsl.checking.stage.fitted_stage import UnfitStageError, fitted_stage
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.documents.program import ProgramDocument
    from cbdsl.documents.stage import StageDocument, empty_stage

    wanted = name or program.stage
    if wanted is None and library.read_as_written(program_file, ProgramDocument).document.roles:
        return empty_stage(program.robot)
    if wanted is None:
        known = _stages_for(program.robot, program_file, library)
        raise UsageError(f"{program.name} names no stage; give one (known: {known})")
    file = locate(StageDocument, wanted, program_file, library)
    require_clean(file, library)
    parts = tuple(program.parameters.values())
    try:
        stage = fitted_stage(library.read(file, StageDocument), robot, robot_file, parts)
    except UnfitStageError as error:
        raise UsageError(f"{file}: {error}") from None
    if stage.robot != program.robot:
        raise UsageError(
            f"{file}: stage '{stage.name}' is for robot '{stage.robot}', "
            f"but program '{program.name}' is for '{program.robot}'"
        )
    return stage


def _stages_for(robot: str, program_file: Path, library: Library) -> str:
    """Return the names of the stages for a robot."""
    from cbdsl.checking.lookup.document_search import for_robot
    from cbdsl.documents.stage import StageDocument

    names = for_robot(StageDocument, robot, program_file, library)
    return ", ".join(names) or f"none; cb new stage NAME --robot {robot} writes one"


def _as_schema(
    program: CheckedProgram,
    name: str,
    program_file: Path,
    library: Library,
    values: Mapping[str, str],
) -> CheckedProgram:
    """Return a program that is allocated by a schema."""
    from cbdsl.api.reading.clean import require_clean
    from cbdsl.checking.cause_order import causes_first
    from cbdsl.checking.program import examiner
    from cbdsl.checking.schema import checked_schema
    from cbdsl.checking.session import Session
    from cbdsl.diagnostics.diagnostics import Diagnostics
    from cbdsl.diagnostics.errors import DiagnosticsError
    from cbdsl.diagnostics.outcome import Unknown
    from cbdsl.documents.schema import SchemaDocument

    file = locate(SchemaDocument, name, program_file, library)
    on_robot = {ROBOT: program.robot, **values}
    require_clean(file, library, {ROBOT: program.robot})
    # The next check has the given values of parameters, which `require_clean` does not know.
    loaded, diagnostics = library.read(file, SchemaDocument), Diagnostics()
    require_served(file, loaded.document, program)
    session = Session(library)
    checked = checked_schema(loaded, session, diagnostics, examiner(session), on_robot)
    if isinstance(checked, Unknown):
        raise DiagnosticsError(causes_first(diagnostics.sorted(), library))
    return checked
