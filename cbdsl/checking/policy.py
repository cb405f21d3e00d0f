"""Checks of policy documents against the programs that they serve."""

from __future__ import annotations

from cbdsl.checking.knowledge.home_robot import home_values
from cbdsl.checking.knowledge.policy_agreement import check_policy
from cbdsl.checking.lookup.document_search import find_document
from cbdsl.checking.program import examine_program
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import Unknown
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
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
