"""Warnings about a robot that a person hardly meant: speeds beyond reason, meshes that are gone."""

from __future__ import annotations

import math

from cbdsl.checking.findings import Findings
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.urdf import UrdfModel
from cbdsl.types.resource_type import TYPES
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.source_map import Step

# Eight turns a second, and 180 km/h: no arm comes near either.
_FASTEST = {"rad": 50.0, "m": 50.0}


def check_speeds(loaded: Loaded[RobotDocument], findings: Findings) -> None:
    """Warn of speeds that no robot has, as degrees that are taken for radians are."""
    control = loaded.document.control
    speeds: list[tuple[tuple[Step, ...], float, str]] = [
        (("control", "joint_speed"), control.joint_speed, "rad")
    ]
    for name, settings in control.tasks.items():
        if settings.speed is not None and name in TYPES:
            unit = str(TYPES[name].unit)
            speeds.append((("control", "tasks", name, "speed"), settings.speed, unit))
    for steps, speed, unit in speeds:
        if speed > _FASTEST.get(unit, math.inf):
            details = {"speed": f"{speed:g} {unit}/s", "most": f"{_FASTEST[unit]:g} {unit}/s"}
            findings.add("CB740", loaded.source.place(*steps), **details)


def check_meshes(loaded: Loaded[RobotDocument], model: UrdfModel, findings: Findings) -> None:
    """Warn of meshes that are not where the model says: engines that draw them refuse it."""
    meshes = model.meshes
    if not meshes:
        return
    from cbdsl.robot.mesh_file import find_mesh  # most robots of a check have none

    folder = model.path.parent
    missing = [name for name in meshes if find_mesh(name, folder) is None]
    if missing:
        more = f", and {len(missing) - 1} more" if len(missing) > 1 else ""
        details = {"file": missing[0], "link": meshes[missing[0]], "more": more}
        findings.add("CB741", loaded.source.place("model"), **details)
