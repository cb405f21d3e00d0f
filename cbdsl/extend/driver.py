"""Kinds of drivers: transports to a real robot, for the entry-point group ``cbdsl.drivers``.

An entry is a ``DriverKind``: the rules for the addresses in a robot's document, and the place of a
``DriverLinkFactory``, which opens a ``DriverLink``. A link returns samples without waiting and
sends commands; stamps are s since the epoch, positions rad or m, wrenches N and N m. It reports
broken messages as ``FaultSample``, and raises ``BackendError`` if it cannot be opened. The contract
test is ``cbdsl.extend.contract.test_driver``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.extend.lazy_names import lazy_names

if TYPE_CHECKING:
    from cbdsl.backends.backend import BackendError
    from cbdsl.backends.driver_link import (
        DriverLink,
        DriverLinkFactory,
        Endpoint,
        Setup,
        StagingLink,
    )
    from cbdsl.backends.driver_sample import (
        CameraSample,
        Command,
        DescriptionSample,
        FaultSample,
        ImageSample,
        JointSample,
        PublishersSample,
        RegionsSample,
        Sample,
        StopSample,
        WrenchSample,
    )
    from cbdsl.backends.engines import extra_advice
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.documents.driver import Driver, absolute
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.kinematics.self_contacts import SelfContacts
    from cbdsl.numeric.arrays import Booleans
    from cbdsl.robot.driver_addresses import addresses
    from cbdsl.robot.driver_kind import DRIVERS, DriverKind, Problem
    from cbdsl.robot.stopping_time import acceleration, horizon, stopping_lines, stopping_times
    from cbdsl.robot.urdf import UrdfError, UrdfJoint, UrdfModel
    from cbdsl.robot.urdf_reader import parse_urdf

__all__ = [
    "DRIVERS", "BackendError", "Booleans", "CameraSample", "Command", "DescriptionSample",
    "Driver", "DriverKind", "DriverLink", "DriverLinkFactory", "Endpoint", "FaultSample",
    "ImageSample", "JointSample", "Problem", "PublishersSample", "RegionsSample",
    "RobotDocument", "Sample", "SelfContacts", "Setup", "StagingLink", "StopSample",
    "UrdfError", "UrdfJoint", "UrdfModel", "UsageError", "WrenchSample", "absolute",
    "acceleration", "addresses", "extra_advice", "horizon", "parse_urdf", "stopping_lines",
    "stopping_times",
]  # fmt: skip

__getattr__ = lazy_names(__file__)
