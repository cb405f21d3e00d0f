"""Warnings about implausible robot settings, and notes on assumptions about the robot's model."""

from __future__ import annotations

import math

from cbdsl.diagnostics.counting import some
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.urdf import UrdfModel
from cbdsl.types.resource_type import TYPES
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.source_map import Step

# Eight turns a second, and 180 km/h: no arm comes near either.
_FASTEST = {"rad": 50.0, "m": 50.0}


def check_speeds(loaded: Loaded[RobotDocument], diagnostics: Diagnostics) -> None:
    """Warn of implausibly high speeds, such as degrees that were read as radians."""
    control = loaded.document.control
    speeds: list[tuple[tuple[Step, ...], float, str]] = [
        (("control", "joint_speed"), control.joint_speed, "rad")
    ]
    for name, settings in control.tasks.items():
        if settings.speed is not None and name in TYPES:
            unit = TYPES[name].unit.partition(" or ")[0]
            speeds.append((("control", "tasks", name, "speed"), settings.speed, unit))
    for steps, speed, unit in speeds:
        if speed > _FASTEST.get(unit, math.inf):
            details = {"speed": f"{speed:g} {unit}/s", "most": f"{_FASTEST[unit]:g} {unit}/s"}
            diagnostics.add("CB740", loaded.source.place(*steps), **details)


def note_assumptions(
    loaded: Loaded[RobotDocument], model: UrdfModel, diagnostics: Diagnostics
) -> None:
    """Note links without collision geometry, and drives whose effort is taken to be unlimited."""
    robot, place = loaded.document, loaded.source.place("model")
    # A link that only houses a camera needs no geometry for contacts.
    housings = {camera.link for camera in robot.cameras.values()}
    shapeless = [link for link in model.shapeless if link not in housings]
    if shapeless:
        diagnostics.add("CB742", place, model=model.path.name, links=some(shapeless))
    driven = [joint for effector in robot.effectors.values() for joint in effector.joints]
    zero = [name for name in driven if name in model.joints and _is_unbounded(model, robot, name)]
    if zero:
        diagnostics.add("CB743", place, model=model.path.name, joints=some(zero))


def _is_unbounded(model: UrdfModel, robot: RobotDocument, joint: str) -> bool:
    """Return whether the model states an effort of 0 for a joint and the document sets no bound."""
    return model.joints[joint].zero_effort and joint not in robot.simulation.efforts
