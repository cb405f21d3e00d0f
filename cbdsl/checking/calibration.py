"""Checks of calibration documents against their robots."""

from __future__ import annotations

from cbdsl.checking.lookup.document_search import find_document
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import UNKNOWN, Unknown
from cbdsl.documents.calibration import CalibrationDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.yaml_text.loaded import Loaded


def examine_calibration(
    loaded: Loaded[CalibrationDocument], session: Session, diagnostics: Diagnostics
) -> None:
    """Check that a calibration names cameras that its robot has."""
    name, source = loaded.document.robot, loaded.source
    path = find_document(RobotDocument, name, source.place("robot"), session.library, diagnostics)
    body = session.body(path, diagnostics)
    if isinstance(body, Unknown):
        return
    cameras = body.document.cameras
    for camera in loaded.document.cameras:
        if camera not in cameras and not isinstance(camera, Unknown):
            place = source.key("cameras", camera)
            diagnostics.add("CB375", place, names=cameras, name=camera, robot=name)


def check_own_calibration(
    loaded: Loaded[RobotDocument], session: Session, diagnostics: Diagnostics
) -> None:
    """Check that the calibration that a robot refers to is its own."""
    name, robot = loaded.document.calibration, loaded.document.name
    if name is None or isinstance(name, Unknown):
        return
    path = session.library.find(CalibrationDocument, name, loaded.path)
    calibration = session.read(path or UNKNOWN, CalibrationDocument, diagnostics)
    if not isinstance(calibration, Unknown) and calibration.document.robot != robot:
        other = calibration.document.robot
        place = loaded.source.place("calibration")
        diagnostics.add("CB603", place, name=name, other=other, robot=robot)
