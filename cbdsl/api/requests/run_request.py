"""Request of a command: a program on a stage, located, read and checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from cbdsl.types.role import ROBOT

if TYPE_CHECKING:
    from cbdsl.documents.document import Document
    from cbdsl.documents.document_digest import ProgramDigest
    from cbdsl.documents.policy import PolicyDocument
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.documents.schema import SchemaDocument
    from cbdsl.documents.stage import StageDocument
    from cbdsl.program.checked import CheckedProgram
    from cbdsl.yaml_text.library import Library
    from cbdsl.yaml_text.loaded import Loaded


@dataclass(frozen=True)
class RunRequest:
    """Program on a stage, read and checked.

    Attributes:
        program: Program to run.
        program_file: Document of the program.
        robot: Robot that runs it.
        urdf: URDF file of the robot.
        stage: Stage to run on.
        library: Library that found all documents.
        values: Given values of the program's parameters, by name.
    """

    program: CheckedProgram
    program_file: Path
    robot: RobotDocument
    urdf: Path
    stage: StageDocument
    library: Library
    values: Mapping[str, str] = field(default_factory=dict)

    def at_rate(self, rate: float | None) -> RunRequest:
        """Return the request with a control rate, Hz; its own if ``None``.

        Raises:
            UsageError: The robot's document does not fit the rate.
        """
        from cbdsl.robot.control_rate import with_control_rate

        return replace(self, robot=with_control_rate(self.robot, rate))

    @property
    def digest(self) -> ProgramDigest:
        """Digest of the program and of the policies that it uses."""
        from cbdsl.checking.knowledge.program_digest import program_digest

        return program_digest(self.program_file, self.library, self.program.robot)


def read_program(program: str, policy: str | None, values: Mapping[str, str]) -> CheckedProgram:
    """Read and check a program, without a stage.

    Args:
        program: File or name of the program.
        policy: File or name of the policy; the program's own if ``None``.
        values: Values of the program's parameters.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: There is no such document, or the documents do not fit each other.
    """
    from cbdsl.checking.program import check_program
    from cbdsl.documents.program import ProgramDocument
    from cbdsl.yaml_text.library import Library

    library = Library()
    path = library.locate(ProgramDocument, program)
    checked = check_program(path, values, library)
    return checked if policy is None else _under_policy(checked, policy, path, library)


def read_request(
    program: str,
    stage: str | None,
    policy: str | None,
    values: Mapping[str, str],
    *,
    schema: str | None = None,
    calibration: str | None = None,
    body: int | None = None,
    clearance: str | None = None,
    uncalibrated: bool = False,
    folder: Path | None = None,
    given: Mapping[Path, bytes] | None = None,
) -> RunRequest:
    """Read and check the requested documents.

    Args:
        program: File or name of the program.
        stage: File or name of the stage; the program's own if ``None``.
        policy: File or name of the policy; the program's own if ``None``.
        values: Values of the program's parameters.
        schema: File or name of the schema, with a policy of its own; no allocation if ``None``.
        calibration: File or name of the cameras' calibration; the robot's own if ``None``.
        body: Number of the simulated body; the stage's if ``None``.
        clearance: Least distance between links, such as ``2 cm``; the program's if ``None``.
        uncalibrated: True if the robot uses the camera poses of its model.
        folder: Folder to search for documents by name; the working folder if ``None``.
        given: Contents that replace those of files.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: There is no such document, or the documents do not fit each other.
    """
    from cbdsl.api.reading.calibration import read_calibration, require_body, with_body
    from cbdsl.checking.program import check_program
    from cbdsl.documents.calibration import calibrated, with_corrections
    from cbdsl.documents.program import ProgramDocument
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.yaml_text.library import Library

    library = Library(folder, given)
    path = library.locate(ProgramDocument, program)
    checked = check_program(path, values, library)
    robot_file = library.find(RobotDocument, checked.robot, path)
    assert robot_file is not None, "a checked program has a robot"
    robot = library.read(robot_file, RobotDocument).document
    learned = checked
    # A policy chooses among the actions of this program. A schema makes another program, with an
    # allocation of resources for each context.
    if policy is not None:
        learned = _under_policy(checked, policy, path, library)
    elif schema is not None:
        learned = _as_schema(checked, schema, path, library, values)
    shown = with_body(_read_stage(stage, checked, path, robot, robot_file, library), body)
    # Empty corrections replace those of the document, so that the cameras are as in the model.
    if uncalibrated:
        robot = with_corrections(robot, {})
    elif known := read_calibration(calibration, robot, robot_file, library):
        require_body(known, shown)
        robot = calibrated(robot, known)
    urdf = robot_file.parent / robot.model
    return RunRequest(
        program=_guarded(learned, shown, robot, urdf, clearance),
        program_file=path,
        robot=robot,
        urdf=urdf,
        stage=shown,
        library=library,
        values=values,
    )


def _guarded(
    program: CheckedProgram,
    stage: StageDocument,
    robot: RobotDocument,
    urdf: Path,
    clearance: str | None,
) -> CheckedProgram:
    """Return a program with a given clearance, and with the fixtures to keep away from.

    Raises:
        UsageError: The clearance is not a length above 0, the stage has no such fixture, or a link
            starts too near another one or a fixture.
    """
    names = program.all_guards.fixtures
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
    if near := too_near_at_start(with_places(robot, hulls), read_urdf(urdf), least):
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
    file = _locate(StageDocument, wanted, program_file, library)
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


def _locate(kind: type[Document], name: str, program_file: Path, library: Library) -> Path:
    """Return the file of a path, or of a name beside the program or in the current folder."""
    return library.find(kind, name, program_file) or library.locate(kind, name)


def _stages_for(robot: str, program_file: Path, library: Library) -> str:
    """Return the names of the stages for a robot."""
    from cbdsl.checking.lookup.document_search import for_robot
    from cbdsl.documents.stage import StageDocument

    names = for_robot(StageDocument, robot, program_file, library)
    return ", ".join(names) or f"none; cb new stage NAME --robot {robot} writes one"


def _under_policy(
    program: CheckedProgram, name: str, program_file: Path, library: Library
) -> CheckedProgram:
    from cbdsl.checking.knowledge.policy_agreement import with_policy

    return with_policy(program, read_policy(program, name, program_file, library), library)


def read_policy(
    program: CheckedProgram, name: str, program_file: Path, library: Library
) -> Loaded[PolicyDocument]:
    """Read a policy that serves a program.

    Args:
        program: Program that the policy serves.
        name: File, or name beside the program or in the current folder.
        program_file: Document of the program.
        library: Library that finds documents by name.

    Raises:
        DiagnosticsError: The policy has errors.
        UsageError: There is no such policy, or it serves another program.
    """
    from cbdsl.api.reading.clean import require_clean
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.documents.policy import PolicyDocument

    file = _locate(PolicyDocument, name, program_file, library)
    # Recordings and policies both come from commands, so that one is easily named for the other.
    if _is_recording(file):
        raise UsageError(f"{file}: this is not a policy document; it looks like a recording")
    require_clean(file, library, {ROBOT: program.robot, **program.parameters})
    loaded = library.read(file, PolicyDocument)
    _require_served(file, loaded.document, program)
    return loaded


def find_schema(
    program: CheckedProgram, name: str, program_file: Path, library: Library
) -> Loaded[SchemaDocument] | None:
    """Return the schema of a program on any robot, or ``None`` if the name is not one of a schema.

    Args:
        program: Program that the schema serves.
        name: File, or name beside the program or in the current folder.
        program_file: Document of the program.
        library: Library that finds documents by name.

    Raises:
        DiagnosticsError: The file cannot be read.
        UsageError: The schema is of another program.
    """
    from cbdsl.documents.document import Document
    from cbdsl.documents.schema import SchemaDocument

    by_name = (library.find(SchemaDocument, name, at) for at in (program_file, library.here / name))
    file = next((each for each in by_name if each is not None), Path(name))
    document = library.read(file, Document).document if file.is_file() else None
    if not isinstance(document, SchemaDocument):
        return None
    _require_served(file, document, program)
    return library.read(file, SchemaDocument)


def _require_served(
    file: Path, knowledge: PolicyDocument | SchemaDocument, program: CheckedProgram
) -> None:
    from cbdsl.diagnostics.errors import UsageError

    if knowledge.program != program.name:
        raise UsageError(
            f"{file}: this {knowledge.kind} serves program '{knowledge.program}', "
            f"not '{program.name}'"
        )


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

    file = _locate(SchemaDocument, name, program_file, library)
    on_robot = {ROBOT: program.robot, **values}
    require_clean(file, library, {ROBOT: program.robot})
    # The next check has the given values of parameters, which `require_clean` does not know.
    loaded, diagnostics = library.read(file, SchemaDocument), Diagnostics()
    _require_served(file, loaded.document, program)
    session = Session(library)
    checked = checked_schema(loaded, session, diagnostics, examiner(session), on_robot)
    if isinstance(checked, Unknown):
        raise DiagnosticsError(causes_first(diagnostics.sorted(), library))
    return checked


def _is_recording(file: Path) -> bool:
    """Return whether a file is one of the two that ``cb run --record`` writes for an episode."""
    if not file.is_file():
        return False
    # The kind is one of the first keys, and a recording may have many megabytes.
    with file.open("rb") as stream:
        is_summary = file.suffix == ".json" and b'"kind": "recording"' in stream.read(4096)
    return is_summary or file.suffix == ".npz"
