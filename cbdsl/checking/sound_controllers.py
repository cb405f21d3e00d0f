"""Controllers without diagnostics, which need no second check while a program is edited."""

from __future__ import annotations

from typing import NamedTuple

from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.documents.program import ControllerSection
from cbdsl.program.controller import Controller


class _Sound(NamedTuple):
    section: ControllerSection
    body: CheckedRobot
    controller: Controller


class SoundControllers:
    """Memory of one program's controllers without diagnostics, by name and name of the robot.

    A controller is unchanged if its section and the robot are. Without parameters, it depends on
    nothing else. Without diagnostics, it refers to no places in the text, which may have moved.
    """

    def __init__(self) -> None:
        self._known: dict[tuple[str, str], _Sound] = {}

    def recall(
        self, name: str, section: ControllerSection, body: CheckedRobot
    ) -> Controller | None:
        """Return the controller of an unchanged section on the same robot, or ``None``."""
        known = self._known.get((name, body.document.name))
        same = known is not None and known.body is body and known.section == section
        return known.controller if known is not None and same else None

    def remember(
        self, name: str, section: ControllerSection, body: CheckedRobot, controller: Controller
    ) -> None:
        """Keep a controller that was checked without a diagnostic, in a document without errors."""
        if "$" not in repr(section):
            self._known[name, body.document.name] = _Sound(section, body, controller)
