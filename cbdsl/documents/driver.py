"""Drivers: the connections of a robot document to a real robot."""

from typing import Annotated, Literal

from pydantic import Field

from cbdsl.documents.document import (
    AnyAcceleration,
    Duration,
    Extent,
    JointName,
    Name,
    Number,
    Section,
)

Address = Annotated[str, Field(min_length=1)]
"""Address of a stream of messages, such as a ROS topic."""


class Driver(Section):
    """A connection to a part of a real robot: joints that it moves, sensors that it reads."""

    kind: Name
    """Kind of the connection, such as ``ros2``."""
    moves: tuple[Name, ...] = ()
    """Effectors or groups whose joints it moves."""
    states: Address | None = None
    """Address of the joint states."""
    commands: Address | None = None
    """Address of the joint references."""
    form: Literal["trajectory", "positions"] = "trajectory"
    """Message of the references: a trajectory with one point, after which the controller holds
    still, or bare positions, which need ``cb drive watchdog``."""
    joints: dict[JointName, str] = {}
    """Names of joints in the driver's messages, where they differ from those of the URDF."""
    wrenches: dict[Name, dict[Name, Address]] = {}
    """Addresses of the load cells' wrenches, by hand and finger."""
    images: dict[Name, Address] = {}
    """Addresses of the images, by camera."""
    camera_info: dict[Name, Address] = {}
    """Addresses of the cameras' intrinsic parameters, by camera."""
    regions: dict[Name, Address] = {}
    """Addresses of segmented regions, by camera, for ``--cameras ideal``."""
    description: Address | None = None
    """Address of the robot's own URDF, whose limits have to equal those of the model."""
    stop: Address | None = None
    """Address of the emergency stop, which is pressed while its message is true."""
    deadline: Duration = 0.05
    """Longest time without a joint state, and longest computation of a control tick."""
    horizon: Duration | None = None
    """Time that the controller takes to a reference, after which it holds still; three control
    periods without one."""
    acceleration: AnyAcceleration | None = None
    """Largest acceleration of a joint's reference, rad/s^2 or m/s^2; without it each joint reaches
    its largest speed in 50 ms."""
    tracking: Extent = 0.3
    """Largest distance of a joint from its reference."""
    start: Extent = 0.05
    """Largest distance of the first reference from the measured position."""
    skew: Duration = 0.05
    """Largest difference between the robot's clock and this computer's."""
    options: dict[Name, Number] = {}
    """Numbers that a kind of another package asks for."""
