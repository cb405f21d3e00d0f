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
    from cbdsl.backends.drivers.joint_limits import joint_limits
    from cbdsl.backends.drivers.limiter import JointLimits
    from cbdsl.backends.drivers.link import (
        DriverLink,
        DriverLinkFactory,
        Endpoint,
        Setup,
        StagingLink,
        require_drivers,
    )
    from cbdsl.backends.drivers.real_time import RealTime
    from cbdsl.backends.drivers.sample import (
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
    from cbdsl.backends.drivers.watchdog import Watchdog, WatchdogPhase
    from cbdsl.documents.driver import Driver, absolute
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.robot.driver_addresses import addresses
    from cbdsl.robot.driver_kind import DriverKind, Problem
    from cbdsl.robot.stopping_time import horizon, stopping_lines

__all__ = [
    "BackendError", "CameraSample", "Command", "DescriptionSample", "Driver", "DriverKind",
    "DriverLink", "DriverLinkFactory", "Endpoint", "FaultSample", "ImageSample", "JointLimits",
    "JointSample", "Problem", "PublishersSample", "RealTime", "RegionsSample", "RobotDocument",
    "Sample", "Setup", "StagingLink", "StopSample", "Watchdog", "WatchdogPhase", "WrenchSample",
    "absolute", "addresses", "horizon", "joint_limits", "require_drivers", "stopping_lines",
]  # fmt: skip

__getattr__ = lazy_names(__file__)
