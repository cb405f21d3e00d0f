"""What several checks share: documents and robots, each read and checked once."""

from __future__ import annotations

from pathlib import Path

from cbdsl.checking.body import Body
from cbdsl.checking.findings import Findings
from cbdsl.checking.robot import examine_robot
from cbdsl.documents.robot import RobotDocument
from cbdsl.yaml_text.library import Library


class Session:
    """One invocation's documents.

    Attributes:
        library: where documents are found by name.
    """

    def __init__(self, library: Library | None = None) -> None:
        self.library = library or Library()
        self._bodies: dict[Path, tuple[Body, Findings]] = {}

    def body(self, path: Path, findings: Findings) -> Body:
        """The robot of a file, whose own findings are added.

        Raises:
            DiagnosticsError: the file holds no robot document.
        """
        key = path.resolve()
        if key not in self._bodies:
            own = Findings()
            body = examine_robot(self.library.read(path, RobotDocument), own)
            self._bodies[key] = body, own
        body, own = self._bodies[key]
        findings.extend(own.sorted())
        return body
