"""The request of a command: a program on a stage, located, read and checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.documents.document import Document
    from cbdsl.documents.policy import PolicyDocument
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.documents.stage import StageDocument
    from cbdsl.program.checked import CheckedProgram
    from cbdsl.yaml_text.library import Library
    from cbdsl.yaml_text.loaded import Loaded


@dataclass(frozen=True)
class RunRequest:
    """A program on a stage, read and checked.

    Attributes:
        program: as it will run.
        program_file: its document.
        robot: what runs it.
        urdf: the robot's model.
        stage: who is shown what, where.
        library: where all of them were found.
    """

    program: CheckedProgram
    program_file: Path
    robot: RobotDocument
    urdf: Path
    stage: StageDocument
    library: Library


def read_request(
    program: str,
    stage: str | None,
    policy: str | None,
    values: Mapping[str, str],
    *,
    schema: str | None = None,
    calibration: str | None = None,
    body: int | None = None,
    uncalibrated: bool = False,
) -> RunRequest:
    """Read and check what a user asks for.

    Args:
        program: a file or a name.
        stage: a file or a name; without it the program's own.
        policy: a file or a name; without it the program's own.
        values: of the program's parameters.
        schema: a file or a name, which brings its own policy; without it nothing is allocated.
        calibration: of the robot's cameras, a file or a name; without it the robot's own.
        body: number of the simulated body; without it the stage's.
        uncalibrated: whether the robot takes its cameras to be where its model has them.

    Raises:
        DiagnosticsError: a document has errors.
        UsageError: there is no such document, or they do not fit each other.
    """
    from cbdsl.api.calibration import read_calibration, require_body, with_body
    from cbdsl.checking.program import check_program
    from cbdsl.documents.calibration import calibrated, with_corrections
    from cbdsl.documents.program import ProgramDocument
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.yaml_text.library import Library

    library = Library()
    path = library.locate(ProgramDocument, program)
    checked = check_program(path, values, library)
    robot_file = library.find(RobotDocument, checked.robot, path)
    assert robot_file is not None, "a checked program has a robot"
    robot = library.read(robot_file, RobotDocument).document
    learned = checked
    if policy is not None:
        learned = _under_policy(checked, policy, path, library)
    elif schema is not None:
        learned = _as_schema(checked, schema, path, library, values)
    shown = with_body(_read_stage(stage, checked, path, library), body)
    if uncalibrated:
        robot = with_corrections(robot, {})
    elif known := read_calibration(calibration, robot, robot_file, library):
        require_body(known, shown)
        robot = calibrated(robot, known)
    return RunRequest(
        program=learned,
        program_file=path,
        robot=robot,
        urdf=robot_file.parent / robot.model,
        stage=shown,
        library=library,
    )


def _read_stage(
    name: str | None, program: CheckedProgram, program_file: Path, library: Library
) -> StageDocument:
    from cbdsl.api.clean import require_clean
    from cbdsl.documents.stage import StageDocument
    from cbdsl.errors.errors import UsageError

    wanted = name or program.stage
    if wanted is None:
        known = _stages_for(program.robot, program_file, library)
        raise UsageError(f"{program.name} names no stage; give one with --stage (known: {known})")
    file = _locate(StageDocument, wanted, program_file, library)
    require_clean(file, library)
    stage = library.read(file, StageDocument).document
    if stage.robot != program.robot:
        raise UsageError(
            f"{file}: stage '{stage.name}' is for robot '{stage.robot}', "
            f"but program '{program.name}' is for '{program.robot}'"
        )
    return stage


def _locate(kind: type[Document], name: str, program_file: Path, library: Library) -> Path:
    """The file that is meant by a path, or by a name beside the program or here."""
    return library.find(kind, name, program_file) or library.locate(kind, name)


def _stages_for(robot: str, program_file: Path, library: Library) -> str:
    """The names of the stages on which a robot is shown something."""
    from cbdsl.checking.lookup.documents import for_robot
    from cbdsl.documents.stage import StageDocument

    names = for_robot(StageDocument, robot, program_file, library)
    return ", ".join(names) or f"none; cb new stage NAME --robot {robot} writes one"


def _under_policy(
    program: CheckedProgram, name: str, program_file: Path, library: Library
) -> CheckedProgram:
    from cbdsl.checking.knowledge.learned import with_policy

    return with_policy(program, read_policy(program, name, program_file, library), library)


def read_policy(
    program: CheckedProgram, name: str, program_file: Path, library: Library
) -> Loaded[PolicyDocument]:
    """Read a policy that serves a program.

    Args:
        program: the program.
        name: a file, or a name beside the program or here.
        program_file: the program's document.
        library: where it is found by name.

    Raises:
        DiagnosticsError: it has errors.
        UsageError: there is no such policy, or it serves another program.
    """
    from cbdsl.api.clean import require_clean
    from cbdsl.documents.policy import PolicyDocument
    from cbdsl.errors.errors import UsageError

    file = _locate(PolicyDocument, name, program_file, library)
    if _is_recording(file):
        raise UsageError(f"{file}: this is no policy document; it looks like a recording")
    require_clean(file, library)
    loaded = library.read(file, PolicyDocument)
    if loaded.document.program != program.name:
        raise UsageError(
            f"{file}: this policy serves program '{loaded.document.program}', not '{program.name}'"
        )
    return loaded


def _as_schema(
    program: CheckedProgram,
    name: str,
    program_file: Path,
    library: Library,
    values: Mapping[str, str],
) -> CheckedProgram:
    """A program that is allocated by a schema."""
    from cbdsl.api.clean import require_clean
    from cbdsl.checking.causes import causes_first
    from cbdsl.checking.findings import Findings
    from cbdsl.checking.program import examine_program
    from cbdsl.checking.schema import checked_schema
    from cbdsl.checking.session import Session
    from cbdsl.documents.schema import SchemaDocument
    from cbdsl.errors.errors import DiagnosticsError, UsageError

    file = _locate(SchemaDocument, name, program_file, library)
    require_clean(file, library)
    loaded, findings = library.read(file, SchemaDocument), Findings()
    if loaded.document.program != program.name:
        raise UsageError(
            f"{file}: this schema is of program '{loaded.document.program}', not '{program.name}'"
        )
    session = Session(library)

    def examine(path: Path, with_: Mapping[str, str], own: Findings) -> CheckedProgram | None:
        return examine_program(path, with_, session, own)

    checked = checked_schema(loaded, session, findings, examine, values)
    if checked is None:
        raise DiagnosticsError(causes_first(findings.sorted(), library))
    return checked


def _is_recording(file: Path) -> bool:
    """Whether a file is one of the two that ``cb run --record`` writes for an episode."""
    if not file.is_file():
        return False
    with file.open("rb") as stream:
        is_summary = file.suffix == ".json" and b'"kind": "recording"' in stream.read(4096)
    return is_summary or file.suffix == ".npz"
