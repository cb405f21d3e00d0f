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
    """Connection to a part of a real robot: its joints and sensors."""

    kind: Name
    """Kind of the connection, such as ``ros2``."""
    moves: tuple[Name, ...] = ()
    """Effectors or groups with the joints that it moves."""
    states: Address | None = None
    """Address of the joint states."""
    commands: Address | None = None
    """Address of the joint references."""
    form: Literal["trajectory", "positions"] = "trajectory"
    """Message of the references: a trajectory with one point, after which the controller holds
    still, or bare positions, which need ``cb drive watchdog``."""
    joints: dict[JointName, str] = {}
    """Names of joints in the driver's messages, if they differ from those of the URDF."""
    wrenches: dict[Name, dict[Name, Address]] = {}
    """Addresses of the load cells' wrenches, by hand and finger."""
    images: dict[Name, Address] = {}
    """Addresses of the images, by camera."""
    camera_info: dict[Name, Address] = {}
    """Addresses of the cameras' intrinsic parameters, by camera."""
    regions: dict[Name, Address] = {}
    """Addresses of segmented regions, by camera, for ``--cameras ideal``."""
    description: Address | None = None
    """Address of the robot's own URDF; its limits must equal those of the model."""
    stop: Address | None = None
    """Address of the emergency stop; it is pressed while its message is true."""
    stop_deadline: Duration | None = None
    """Maximum time between two messages of each publisher of the emergency stop."""
    stop_repeats: bool = True
    """False if the emergency stop sends a message only when it changes. A dead button then stays
    unnoticed until its DDS lease ends, such as 20 s, and pressing it has no effect."""
    deadline: Duration = 0.05
    """Maximum time without a joint state, and maximum computation time of a control tick."""
    horizon: Duration | None = None
    """Time in which the controller reaches a reference and then holds still; three control periods
    if omitted."""
    acceleration: AnyAcceleration | None = None
    """Maximum acceleration of a joint's reference, rad/s^2 or m/s^2; if omitted, each joint reaches
    its maximum speed in 50 ms."""
    tracking: Extent = 0.1
    """Maximum distance of a joint that does not follow from its reference, below ``control.lead``;
    0.3 of it is the maximum motion that is not commanded."""
    start: Extent = 0.05
    """Maximum distance of the first reference from the measured position."""
    skew: Duration = 0.05
    """Maximum difference between the robot's clock and that of this computer."""
    options: dict[Name, Number] = {}
    """Numbers for a kind of driver from another package."""


def absolute(address: str) -> str:
    """Return an address with its leading slash, which documents may omit."""
    return address if address.startswith("/") else f"/{address}"
