"""Policy documents against the programs that they serve."""

from __future__ import annotations

from cbdsl.checking.findings import Findings
from cbdsl.checking.knowledge.learned import check_policy
from cbdsl.checking.lookup.documents import report_unknown
from cbdsl.checking.program import examine_program
from cbdsl.checking.session import Session
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.yaml_text.reader import Loaded


def examine_policy(loaded: Loaded[PolicyDocument], session: Session, findings: Findings) -> None:
    """Check that a policy's predicates, actions and models are those of its program."""
    name, source = loaded.document.program, loaded.source
    path = session.library.find(ProgramDocument, name, loaded.path)
    if path is None and not source.is_whole("program"):
        return
    if path is None:
        place = source.place("program")
        report_unknown(ProgramDocument, name, place, session.library, findings)
        return
    program = examine_program(path, {}, session, findings)
    if program is not None:
        check_policy(loaded, program, path, session, findings)
