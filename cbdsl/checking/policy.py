"""Checks of policy documents against the programs that they serve."""

from __future__ import annotations

from pathlib import Path

from cbdsl.checking.knowledge.policy_agreement import check_policy
from cbdsl.checking.lookup.document_search import find_document
from cbdsl.checking.program import examine_program
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import Unknown
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.types.role import ROBOT
from cbdsl.yaml_text.loaded import Loaded


def examine_policy(
    loaded: Loaded[PolicyDocument], session: Session, diagnostics: Diagnostics
) -> None:
    """Check that a policy's predicates, actions and models are those of its program."""
    name, source = loaded.document.program, loaded.source
    path = find_document(
        ProgramDocument, name, source.place("program"), session.library, diagnostics
    )
    if isinstance(path, Unknown):
        return
    values = home_values(loaded.document, path, session)
    program = examine_program(path, values, session, diagnostics)
    if not isinstance(program, Unknown):
        check_policy(loaded, program, path, session, diagnostics)


def home_values(knowledge: PolicyDocument, program: Path, session: Session) -> dict[str, str]:
    """Return the robot of the session or of the learning, with the effectors in the roles.

    Args:
        knowledge: Learned or written policy.
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
