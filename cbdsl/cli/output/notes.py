"""Notes on the stage of a program, printed before it runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.checking.rules.stage_colors import absent_channels

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest


def notes(request: RunRequest) -> list[str]:
    """Return sentences on colours that a program acts on and no object of its stage has.

    Assumptions about the robot are notes of `cb new robot` and `cb validate` on its document.
    """
    if not request.robot.cameras:
        return []
    channels = absent_channels(request.program, request.stage, request.robot.vision.channels)
    return [f"nothing on stage '{request.stage.name}' is of {channel}" for channel in channels]
