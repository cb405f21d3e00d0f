"""Documents of any kind: all findings in one pass."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from cbdsl.checking.causes import causes_first
from cbdsl.checking.findings import Findings
from cbdsl.checking.knowledge.model import examine_model
from cbdsl.checking.policy import examine_policy
from cbdsl.checking.program import examine_program
from cbdsl.checking.session import Session
from cbdsl.checking.stage import examine_stage
from cbdsl.documents.document import Document
from cbdsl.documents.model import ModelDocument
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.errors.diagnostic import Diagnostic
from cbdsl.errors.errors import DiagnosticsError
from cbdsl.yaml_text.reader import Loaded
from cbdsl.yaml_text.unknown import UNKNOWN


def check_document(
    path: Path, with_: Mapping[str, str] | None = None, session: Session | None = None
) -> list[Diagnostic]:
    """All findings in a document and in what it refers to; causes come first.

    Args:
        path: its file.
        with_: values for those of a program's parameters that it has.
        session: documents that were read before.
    """
    session, findings = session or Session(), Findings()
    try:
        loaded = session.library.read_sound_parts(path, Document)
        findings.extend(loaded.faults)
        _named_like_its_file(loaded, findings)
        _examine(path, loaded, with_ or {}, session, findings)
    except DiagnosticsError as error:
        findings.extend(error.diagnostics)
    return causes_first(findings.sorted(), session.library)


def _named_like_its_file(loaded: Loaded[Document], findings: Findings) -> None:
    """What is on a disk is found by its file's name; what an editor holds may not have one."""
    name, path = loaded.document.name, loaded.path
    if name not in (path.stem, UNKNOWN) and path.is_file():
        findings.add("CB704", loaded.source.place("name"), name=name, file=path.name)


def _examine(
    path: Path,
    loaded: Loaded[Document],
    with_: Mapping[str, str],
    session: Session,
    findings: Findings,
) -> None:
    document = loaded.document
    if isinstance(document, ProgramDocument):
        values = {key: value for key, value in with_.items() if key in document.parameters}
        examine_program(path, values, session, findings)
    elif isinstance(document, RobotDocument):
        session.body(path, findings)
    elif isinstance(document, StageDocument):
        examine_stage(Loaded(document, loaded.source), session, findings)
    elif isinstance(document, ModelDocument):
        examine_model(Loaded(document, loaded.source), session, findings)
    elif isinstance(document, PolicyDocument):
        examine_policy(Loaded(document, loaded.source), session, findings)
