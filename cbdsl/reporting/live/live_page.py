"""Page of a running program."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from cbdsl.documents.robot import RobotDocument
from cbdsl.reporting.bundle import Bundle
from cbdsl.reporting.drawn_links import read_links
from cbdsl.reporting.page import drawn_link
from cbdsl.reporting.template import filled
from cbdsl.robot.joints import Joints

_SCRIPTS = ("vendor/three.min.js", "vendor/uPlot.iife.min.js", "page.js", "data.js", "chart.js",
            "scene.js", "viewpoints.js", "live_world.js", "live_chart.js", "live_stack.js",
            "live_target.js", "steps.js", "live_composer.js", "live_catalog.js", "asking.js",
            "live_breakpoints.js", "live_past.js", "live.js")  # fmt: skip
_STYLES = ("vendor/uPlot.min.css", "page.css", "replay.css", "live.css")


def live_page(
    title: str,
    robot: RobotDocument,
    urdf: Path,
    token: str,
    *,
    composes: bool = False,
    refused: Mapping[str, str] = MappingProxyType({}),
) -> str:
    """Return the page of a robot's episodes; their content comes from its server.

    Args:
        title: Title of the page.
        robot: Robot with the links to draw.
        urdf: URDF file of the robot.
        token: Token that requests have to contain.
        composes: True if the program may be changed on the page.
        refused: Reasons for the refusal of requests, by name.
    """
    bundle, joints = Bundle(), Joints(robot).names
    header: Mapping[str, object] = {
        "token": token,
        "composes": composes,
        "refused": dict(refused),
        "links": [
            drawn_link(link, bundle)
            for link in read_links(_model(robot, urdf), joints, is_recorded=False)
        ],
    }
    text = bundle.text(header)
    return filled("live.html", title, _STYLES, _SCRIPTS, text, {}, connects=True)


def _model(robot: RobotDocument, urdf: Path) -> Mapping[str, object]:
    """Return a robot in the form that ``read_links`` expects."""
    return {
        "urdf": urdf.read_text("utf-8", errors="replace"),
        "folder": str(urdf.parent.resolve()),
        "couplings": {name: coupling.recorded for name, coupling in robot.couplings.items()},
    }
