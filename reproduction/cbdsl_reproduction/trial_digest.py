"""Digest of all inputs of a shipped program's episode, except seed and engine."""

from __future__ import annotations

from collections.abc import Mapping

from cbdsl.api.shipped import shipped_file, shipped_robot
from cbdsl.checking.knowledge.digest import program_digest
from cbdsl.documents.digest import digest_of_text
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.yaml_text.library import Library, shipped


def trial_digest(program: str, values: Mapping[str, str], stage: str) -> str:
    """Return the digest of a shipped program with its dependencies, its robot and a stage.

    Args:
        program: Name of the program.
        values: Values of its parameters.
        stage: Name of a stage, its own or another.
    """
    library = Library(shipped())
    file = shipped_file(library, ProgramDocument, program)
    robot, _ = shipped_robot(library.read(file, ProgramDocument).document.robot, library)
    place = library.read(shipped_file(library, StageDocument, stage), StageDocument).document
    parts = (
        str(program_digest(file, library)),
        # The program's digest does not cover its policy.
        file.read_text(encoding="utf-8"),
        str(sorted(values.items())),
        robot.model_dump_json(),
        place.model_dump_json(),
    )
    return digest_of_text("\n".join(parts))
