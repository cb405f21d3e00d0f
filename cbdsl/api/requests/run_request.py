"""Request of a command: a program on a stage, located, read and checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
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
    return checked if policy is None else under_policy(checked, policy, path, library)


def locate(kind: type[Document], name: str, program_file: Path, library: Library) -> Path:
    """Return the file of a path, or of a name beside the program or in the current folder."""
    return library.find(kind, name, program_file) or library.locate(kind, name)


def under_policy(
    program: CheckedProgram, name: str, program_file: Path, library: Library
) -> CheckedProgram:
    """Return a program under a policy; see ``read_policy``."""
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

    file = locate(PolicyDocument, name, program_file, library)
    # Recordings and policies both come from commands, so that one is easily named for the other.
    if _is_recording(file):
        raise UsageError(f"{file}: this is not a policy document; it looks like a recording")
    require_clean(file, library, {ROBOT: program.robot, **program.parameters})
    loaded = library.read(file, PolicyDocument)
    require_served(file, loaded.document, program)
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
    require_served(file, document, program)
    return library.read(file, SchemaDocument)


def require_served(
    file: Path, knowledge: PolicyDocument | SchemaDocument, program: CheckedProgram
) -> None:
    """Check that learned knowledge is about a program.

    Raises:
        UsageError: It is about another one.
    """
    from cbdsl.diagnostics.errors import UsageError

    if knowledge.program != program.name:
        raise UsageError(
            f"{file}: this {knowledge.kind} serves program '{knowledge.program}', "
            f"not '{program.name}'"
        )


def _is_recording(file: Path) -> bool:
    """Return whether a file is one of the two that ``cb run --record`` writes for an episode."""
    if not file.is_file():
        return False
    # The kind is one of the first keys, and a recording may have many megabytes.
    with file.open("rb") as stream:
        is_summary = file.suffix == ".json" and b'"kind": "recording"' in stream.read(4096)
    return is_summary or file.suffix == ".npz"
