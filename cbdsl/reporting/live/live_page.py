"""The page of a run while it runs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from cbdsl.documents.robot import RobotDocument
from cbdsl.reporting.bundle import Bundle
from cbdsl.reporting.model import read_links
from cbdsl.reporting.page import drawn_link
from cbdsl.reporting.template import filled
from cbdsl.robot.joints import Joints

_SCRIPTS = ("vendor/three.min.js", "vendor/uPlot.iife.min.js", "page.js", "data.js", "chart.js",
            "scene.js", "viewpoints.js", "live_world.js", "live_chart.js", "live_stack.js",
            "live_target.js", "live_composer.js", "live_catalog.js", "live.js")  # fmt: skip
_STYLES = ("vendor/uPlot.min.css", "page.css", "replay.css", "live.css")


def live_page(
    title: str, robot: RobotDocument, urdf: Path, token: str, *, composes: bool = False
) -> str:
    """The page of a robot's episodes; what happens in them comes from its server.

    Args:
        title: of the page.
        robot: whose links are drawn.
        urdf: its model.
        token: that requests show.
        composes: whether the program may be changed on it.
    """
    bundle, joints = Bundle(), Joints(robot).names
    header: Mapping[str, object] = {
        "token": token,
        "composes": composes,
        "links": [
            drawn_link(link, bundle)
            for link in read_links(_model(robot, urdf), joints, is_recorded=False)
        ],
    }
    text = bundle.text(header)
    return filled("live.html", title, _STYLES, _SCRIPTS, text, {}, connects=True)


def _model(robot: RobotDocument, urdf: Path) -> Mapping[str, object]:
    """A robot as ``read_links`` takes it."""
    return {
        "urdf": urdf.read_text("utf-8", errors="replace"),
        "folder": str(urdf.parent.resolve()),
        "couplings": {name: coupling.recorded for name, coupling in robot.couplings.items()},
    }
