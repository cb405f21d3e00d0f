"""Fit of a robot file to its URDF model."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path

from cbdsl.backends.backend import BackendError
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.chains import root
from cbdsl.robot.meshes.model_meshes import damaged_meshes, missing_meshes
from cbdsl.robot.urdf import UrdfError, UrdfModel
from cbdsl.robot.urdf_reader import read_urdf


def read_fitting(robot: RobotDocument, urdf: Path) -> UrdfModel:
    """Read the model of a robot.

    Raises:
        BackendError: The model cannot be read, has a damaged mesh, or lacks a part that the robot
            file names.
    """
    try:
        model = read_urdf(urdf)
    except UrdfError as error:
        raise BackendError(f"the model cannot be read: {error}") from error
    aimless = [joint.name for joint in model.joints.values() if not joint.directed]
    if aimless:
        raise BackendError(f"{urdf.name} gives joint '{aimless[0]}' an axis without a direction")
    _require_sound_meshes(model)
    base = root(model)
    if base != robot.base:
        raise BackendError(
            f"robot '{robot.name}' has the base '{robot.base}', "
            f"but the root link of {urdf.name} is '{base}'"
        )
    joints = [joint for effector in robot.effectors.values() for joint in effector.joints]
    missing = set(joints + list(robot.couplings)) - set(model.movable)
    if missing:
        raise BackendError(
            f"{urdf.name} has no movable joint {', '.join(map(repr, sorted(missing)))}, "
            f"which robot '{robot.name}' names"
        )
    for link in _links(robot):
        if link not in model.links:
            raise BackendError(
                f"{urdf.name} has no link '{link}', which robot '{robot.name}' names"
            )
    return model


def require_meshes(model: UrdfModel, needed: Collection[str]) -> None:
    """Check that the files of the meshes that an engine needs exist.

    Args:
        model: Model of the robot.
        needed: Files of meshes, as the model names them.

    Raises:
        BackendError: One is missing.
    """
    for fault in missing_meshes(model):
        if fault.file in needed:
            raise BackendError(
                f"{model.path.name}: mesh '{fault.file}' of link '{fault.link}' does not exist; "
                f"put it there, or use the engine kinematic, which reads no mesh"
            )


def _require_sound_meshes(model: UrdfModel) -> None:
    # Documents are checked in the same way when they are read; robots of other sources are not.
    for fault in damaged_meshes(model):
        raise BackendError(
            f"{model.path.name}: mesh '{fault.file}' of link '{fault.link}' is damaged: "
            f"{fault.damage}; export it or download it again"
        )


def physics_steps(robot: RobotDocument) -> int:
    """Return the number of physics steps per control period.

    Raises:
        BackendError: The number is not a positive integer.
    """
    ratio = robot.simulation.physics_rate / robot.control.rate
    if round(ratio) < 1 or abs(ratio - round(ratio)) > 1e-9:
        raise BackendError(
            f"robot '{robot.name}': the physics rate, {robot.simulation.physics_rate:g} Hz, "
            f"must be a multiple of the control rate, {robot.control.rate:g} Hz"
        )
    return round(ratio)


def _links(robot: RobotDocument) -> Iterator[str]:
    """Yield the links that a robot file names for its sensors and tips."""
    yield from (camera.link for camera in robot.cameras.values())
    yield from (cell.link for cells in robot.load_cells.values() for cell in cells.values())
    yield from (each.tip.link for each in robot.effectors.values() if each.tip is not None)
