"""Backends: robots in a world, for the entry-point group ``cbdsl.backends``.

An entry is a class with the constructor of ``BackendFactory`` and the methods of ``Backend``; see
both for shapes and units. A real robot also has the method of ``AttendedBackend``, and a world that
persists between episodes that of ``ResumableBackend``. Failures are raised as ``BackendError``; the
message states the cause and a remedy. The contract test is ``cbdsl.extend.contract.test_backend``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.extend.lazy_names import lazy_names

if TYPE_CHECKING:
    from cbdsl.api.reading.robots import read_robot, read_stage
    from cbdsl.backends.backend import (
        AttendedBackend,
        Backend,
        BackendError,
        BackendFactory,
        Person,
        ResumableBackend,
        StagingBackend,
        embody,
    )
    from cbdsl.backends.cameras.light import AMBIENT, DIRECTION
    from cbdsl.backends.cameras.selection import make_cameras
    from cbdsl.backends.cameras.view import FARTHEST, NEAREST, View
    from cbdsl.backends.simulated_backend import SimulatedBackend
    from cbdsl.backends.staging.engine import ROOM, Engine
    from cbdsl.backends.staging.episode_start import choose_context, draw_start
    from cbdsl.backends.staging.fit import physics_steps, read_fitting, require_meshes
    from cbdsl.backends.staging.links import link_surfaces, pairs_without_contact
    from cbdsl.backends.staging.scenario import GRAVITY, SceneObject
    from cbdsl.backends.staging.shape import SolidShape
    from cbdsl.backends.staging.solids import POSITION, ROTATION, WIDTH, solid_row
    from cbdsl.backends.staging.world_state import Part
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.documents.context import PlaceSection
    from cbdsl.documents.form import MeshForm
    from cbdsl.documents.robot import Coupling, RobotDocument
    from cbdsl.documents.simulation_section import MujocoSection
    from cbdsl.documents.stage import StageDocument, Surface
    from cbdsl.kinematics.kinematics import Kinematics
    from cbdsl.kinematics.link_mass import LinkMass, link_masses
    from cbdsl.kinematics.pose import Pose, displacement
    from cbdsl.numeric.arrays import Floats, Image, Rows
    from cbdsl.numeric.compiled import compiled_once, load_kept
    from cbdsl.robot.control_rate import with_control_rate
    from cbdsl.robot.joints import Joints
    from cbdsl.robot.meshes.mesh_file import find_mesh
    from cbdsl.robot.meshes.mesh_reader import MeshError, read_mesh_file
    from cbdsl.robot.urdf import UrdfJoint, UrdfModel, UrdfShape
    from cbdsl.robot.urdf_reader import read_urdf
    from cbdsl.sensing.channels import Extent, Moments, Region, Regions, connected_regions
    from cbdsl.sensing.observation import Cell, Loads, Observation

__all__ = [
    "AMBIENT", "DIRECTION", "FARTHEST", "GRAVITY", "NEAREST", "POSITION", "ROOM", "ROTATION",
    "WIDTH", "AttendedBackend", "Backend", "BackendError", "BackendFactory", "Cell", "Coupling",
    "Engine", "Extent", "Floats", "Image", "Joints", "Kinematics", "LinkMass", "Loads", "MeshError",
    "MeshForm", "Moments", "MujocoSection", "Observation", "Part", "Person", "PlaceSection", "Pose",
    "Region", "Regions", "ResumableBackend", "RobotDocument", "Rows", "SceneObject",
    "SimulatedBackend", "SolidShape", "StageDocument", "StagingBackend", "Surface", "UrdfJoint",
    "UrdfModel", "UrdfShape", "UsageError", "View", "choose_context", "compiled_once",
    "connected_regions", "displacement", "draw_start", "embody", "find_mesh", "link_masses",
    "link_surfaces", "load_kept", "make_cameras", "pairs_without_contact", "physics_steps",
    "read_fitting", "read_mesh_file", "read_robot", "read_stage", "read_urdf", "require_meshes",
    "solid_row", "with_control_rate",
]  # fmt: skip

__getattr__ = lazy_names(__file__)
