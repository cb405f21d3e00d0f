"""Notes on a robot and its stage, printed before it runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.checking.document import check_document
from cbdsl.checking.rules.stage_colors import absent_channels
from cbdsl.checking.session import Session
from cbdsl.checking.suppression import apply_suppressions
from cbdsl.diagnostics.diagnostic import Severity
from cbdsl.documents.robot import RobotDocument

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest


def notes(request: RunRequest) -> list[str]:
    """Assumptions about a robot that its document does not silence, and colours of no object."""
    library = request.library
    file = library.find(RobotDocument, request.program.robot, request.program_file)
    if file is None:
        return []
    channels = request.robot.vision.channels
    absent = (
        absent_channels(request.program, request.stage, channels) if request.robot.cameras else ()
    )
    diagnostics = apply_suppressions(check_document(file, Session(library)), [], library)
    return [
        *(each.message for each in diagnostics if each.severity is Severity.NOTE),
        *(f"nothing on stage '{request.stage.name}' is of {channel}" for channel in absent),
    ]
