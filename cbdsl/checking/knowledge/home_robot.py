"""Robot with which knowledge of a program over roles is checked."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from cbdsl.checking.session import Session
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.types.role import ROBOT

if TYPE_CHECKING:
    from cbdsl.documents.schema import SchemaDocument


def home_values(
    knowledge: PolicyDocument | SchemaDocument, program: Path, session: Session
) -> dict[str, str]:
    """Return the robot of the session or of the learning, with the effectors in the roles.

    Args:
        knowledge: Learned or written knowledge.
        program: File of its program.
        session: Session with the documents read so far.

    Returns:
        Values by parameter; empty for a program of one robot, or if the robot is not at hand.
    """
    roles = session.library.read_as_written(program, ProgramDocument).document.roles
    given = {key: v for key, v in session.values.items() if roles and key in (ROBOT, *roles)}
    learned = knowledge.provenance
    if not roles or learned is None or ROBOT in given:
        return given
    if session.library.find(RobotDocument, learned.robot.name, program) is None:
        return given
    chosen = {key: value for key, value in learned.parameters.items() if key in roles}
    return {ROBOT: learned.robot.name, **chosen, **given}
