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
    from cbdsl.backends.simulated_backend import SimulatedBackend
    from cbdsl.backends.staging.engine import Engine
    from cbdsl.backends.staging.episode_start import choose_context, draw_start
    from cbdsl.backends.staging.fit import read_fitting
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.documents.context import PlaceSection
    from cbdsl.documents.form import MeshForm
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.documents.stage import StageDocument
    from cbdsl.kinematics.kinematics import Kinematics
    from cbdsl.numeric.arrays import Floats, Image
    from cbdsl.numeric.compiled import load_kept
    from cbdsl.robot.control_rate import with_control_rate
    from cbdsl.robot.joints import Joints
    from cbdsl.robot.urdf_reader import read_urdf
    from cbdsl.sensing.channels import Extent, Moments, Region, Regions, connected_regions
    from cbdsl.sensing.observation import Loads, Observation

__all__ = [
    "AttendedBackend", "Backend", "BackendError", "BackendFactory", "Engine", "Extent",
    "Floats", "Image", "Joints", "Kinematics", "Loads", "MeshForm", "Moments", "Observation",
    "Person", "PlaceSection", "Region", "Regions", "ResumableBackend", "RobotDocument",
    "SimulatedBackend", "StageDocument", "StagingBackend", "UsageError", "choose_context",
    "connected_regions", "draw_start", "embody", "load_kept", "read_fitting", "read_robot",
    "read_stage", "read_urdf", "with_control_rate",
]  # fmt: skip

__getattr__ = lazy_names(__file__)
