"""Policy documents against the programs that they serve."""

from __future__ import annotations

from cbdsl.checking.findings import Findings
from cbdsl.checking.program import examine_program
from cbdsl.checking.session import Session
from cbdsl.checking.states import check_states
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.language.parser import CompositionError, parse
from cbdsl.program.checked import CheckedProgram
from cbdsl.yaml_text.reader import Loaded


def examine_policy(loaded: Loaded[PolicyDocument], session: Session, findings: Findings) -> None:
    """Check that a policy's predicates and actions are those of its program."""
    name, source = loaded.document.program, loaded.source
    path = session.library.find(ProgramDocument, name, loaded.path)
    if path is None:
        names = session.library.names(ProgramDocument, loaded.path)
        findings.add("CB604", source.place("program"), names=names, name=name)
        return
    program = examine_program(path, {}, session, findings)
    if program is not None:
        _fits(loaded, program, findings)


def _fits(loaded: Loaded[PolicyDocument], program: CheckedProgram, findings: Findings) -> None:
    document, source = loaded.document, loaded.source
    if document.predicates != program.members:
        found, wanted = ", ".join(document.predicates), ", ".join(program.members)
        details = {"found": found, "wanted": wanted, "program": program.name}
        findings.add("CB621", source.key("predicates"), **details)
    names = [action.name for action in program.actions]
    for pattern, text in document.policy.items():
        steps = ("policy", pattern)
        try:
            action = str(parse(text))
        except CompositionError as error:
            place = source.inside(steps, error.span.start, error.span.end)
            findings.add("CB401", place, problem=str(error))
            continue
        if action not in names:
            findings.add("CB613", source.place(*steps), names=names, name=action)
    check_states(document.policy, document.predicates, source, findings)
