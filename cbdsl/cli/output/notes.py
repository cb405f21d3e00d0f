"""Notes on a robot, printed before it runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.checking.suppression import apply_suppressions
from cbdsl.diagnostics.diagnostic import Severity
from cbdsl.documents.robot import RobotDocument

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest


def notes(request: RunRequest) -> list[str]:
    """Assumptions about a robot, one sentence each, unless its document silences it."""
    library = request.library
    file = library.find(RobotDocument, request.program.robot, request.program_file)
    if file is None:
        return []
    diagnostics = apply_suppressions(check_document(file, Session(library)), [], library)
    return [
        diagnostic.message for diagnostic in diagnostics if diagnostic.severity is Severity.NOTE
    ]
