"""Checks of the mesh files that a robot's model names."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.urdf import UrdfModel
from cbdsl.yaml_text.loaded import Loaded

if TYPE_CHECKING:
    from cbdsl.robot.meshes.model_meshes import FaultyMesh


def check_meshes(loaded: Loaded[RobotDocument], model: UrdfModel, diagnostics: Diagnostics) -> None:
    """Warn of missing mesh files, and report damaged ones.

    An engine that reads no mesh can run a model without them. A damaged mesh is an error for all
    engines, because each would treat it differently.
    """
    if not model.meshes:
        return
    # Most robots of a check have no meshes.
    from cbdsl.robot.meshes.model_meshes import damaged_meshes, missing_meshes

    for code, faults in (("CB741", missing_meshes(model)), ("CB366", damaged_meshes(model))):
        if faults:
            diagnostics.add(code, loaded.source.place("model"), **_details(faults))


def _details(faults: list[FaultyMesh]) -> dict[str, str]:
    more = f", and {len(faults) - 1} more" if len(faults) > 1 else ""
    file, link, damage = faults[0]
    return {"file": file, "link": link, "problem": damage, "more": more}
