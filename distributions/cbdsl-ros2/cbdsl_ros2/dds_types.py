"""Messages of ROS 2 as types of DDS, with the names that rmw gives them, and their CDR.

The fields are those of Humble to Kilted. ``IdlStruct`` encodes them; images and regions, which are
large, have encodings of their own here.
"""

import struct
from dataclasses import dataclass, field
from typing import Any, Self

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import array, float64, int8, int32, sequence, uint8, uint32

_NANO = 1_000_000_000


class _Seconds:
    """Conversion of seconds and nanoseconds from and to seconds."""

    sec: int32
    nanosec: uint32

    @classmethod
    def of(cls, seconds: float) -> Self:
        """Return the value of some seconds."""
        return cls(*divmod(round(seconds * _NANO), _NANO))

    @property
    def seconds(self) -> float:
        """The value in seconds."""
        return float(self.sec + self.nanosec / _NANO)


@dataclass
@final
class Time(IdlStruct, _Seconds, typename="builtin_interfaces::msg::dds_::Time_"):
    """Time since the epoch."""

    sec: int32 = 0
    nanosec: uint32 = 0


@dataclass
@final
class Duration(IdlStruct, _Seconds, typename="builtin_interfaces::msg::dds_::Duration_"):
    """Span of time."""

    sec: int32 = 0
    nanosec: uint32 = 0


@dataclass
@final
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    """Time and frame of a measurement."""

    stamp: Time = field(default_factory=Time)
    frame_id: str = ""


@dataclass
@final
class Text(IdlStruct, typename="std_msgs::msg::dds_::String_"):
    """Text, such as the URDF of a robot."""

    data: str = ""


@dataclass
@final
class Flag(IdlStruct, typename="std_msgs::msg::dds_::Bool_"):
    """Truth value, such as that of an emergency stop."""

    data: bool = False


@dataclass
@final
class JointState(IdlStruct, typename="sensor_msgs::msg::dds_::JointState_"):
    """Positions, velocities and efforts of named joints."""

    header: Header = field(default_factory=Header)
    name: sequence[str] = field(default_factory=list)
    position: sequence[float64] = field(default_factory=list)
    velocity: sequence[float64] = field(default_factory=list)
    effort: sequence[float64] = field(default_factory=list)


@dataclass
@final
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    """Vector."""

    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0


@dataclass
@final
class Wrench(IdlStruct, typename="geometry_msgs::msg::dds_::Wrench_"):
    """Force, N, and torque, N m."""

    force: Vector3 = field(default_factory=Vector3)
    torque: Vector3 = field(default_factory=Vector3)


@dataclass
@final
class WrenchStamped(IdlStruct, typename="geometry_msgs::msg::dds_::WrenchStamped_"):
    """Wrench in a frame, at a time."""

    header: Header = field(default_factory=Header)
    wrench: Wrench = field(default_factory=Wrench)


@dataclass
@final
class JointTrajectoryPoint(IdlStruct, typename="trajectory_msgs::msg::dds_::JointTrajectoryPoint_"):
    """References of joints at a time from the start of their trajectory."""

    positions: sequence[float64] = field(default_factory=list)
    velocities: sequence[float64] = field(default_factory=list)
    accelerations: sequence[float64] = field(default_factory=list)
    effort: sequence[float64] = field(default_factory=list)
    time_from_start: Duration = field(default_factory=Duration)


@dataclass
@final
class JointTrajectory(IdlStruct, typename="trajectory_msgs::msg::dds_::JointTrajectory_"):
    """Trajectory of named joints."""

    header: Header = field(default_factory=Header)
    joint_names: sequence[str] = field(default_factory=list)
    points: sequence[JointTrajectoryPoint] = field(default_factory=list)


@dataclass
@final
class MultiArrayDimension(IdlStruct, typename="std_msgs::msg::dds_::MultiArrayDimension_"):
    """Dimension of an array."""

    label: str = ""
    size: uint32 = 0
    stride: uint32 = 0


@dataclass
@final
class MultiArrayLayout(IdlStruct, typename="std_msgs::msg::dds_::MultiArrayLayout_"):
    """Layout of an array; empty for references."""

    dim: sequence[MultiArrayDimension] = field(default_factory=list)
    data_offset: uint32 = 0


@dataclass
@final
class Float64MultiArray(IdlStruct, typename="std_msgs::msg::dds_::Float64MultiArray_"):
    """References of a forward controller, in the order of its joints."""

    layout: MultiArrayLayout = field(default_factory=MultiArrayLayout)
    data: sequence[float64] = field(default_factory=list)


@dataclass
@final
class RegionOfInterest(IdlStruct, typename="sensor_msgs::msg::dds_::RegionOfInterest_"):
    """Part of an image."""

    x_offset: uint32 = 0
    y_offset: uint32 = 0
    height: uint32 = 0
    width: uint32 = 0
    do_rectify: bool = False


@dataclass
@final
class CameraInfo(IdlStruct, typename="sensor_msgs::msg::dds_::CameraInfo_"):
    """Intrinsic parameters of a camera."""

    header: Header = field(default_factory=Header)
    height: uint32 = 0
    width: uint32 = 0
    distortion_model: str = ""
    d: sequence[float64] = field(default_factory=list)
    k: array[float64, 9] = field(default_factory=lambda: [0.0] * 9)
    r: array[float64, 9] = field(default_factory=lambda: [0.0] * 9)
    p: array[float64, 12] = field(default_factory=lambda: [0.0] * 12)
    binning_x: uint32 = 0
    binning_y: uint32 = 0
    roi: RegionOfInterest = field(default_factory=RegionOfInterest)


@dataclass
@final
class Image(IdlStruct, typename="sensor_msgs::msg::dds_::Image_"):
    """Image; ``data`` is ``bytes`` on both sides, which ``IdlStruct`` would take apart."""

    header: Header = field(default_factory=Header)
    height: uint32 = 0
    width: uint32 = 0
    encoding: str = ""
    is_bigendian: uint8 = 0
    step: uint32 = 0
    data: sequence[uint8] = b""

    def serialize(self, *_: Any, **__: Any) -> bytes:
        """Return the message as little-endian CDR with its encapsulation header."""
        head = _CdrWriter()
        head.put("iI", self.header.stamp.sec, self.header.stamp.nanosec)
        head.text(self.header.frame_id)
        head.put("II", self.height, self.width)
        head.text(self.encoding)
        head.put("B", self.is_bigendian)
        head.put("II", self.step, len(self.data))
        return b"\x00\x01\x00\x00" + bytes(head.data) + bytes(self.data)

    @classmethod
    def deserialize(cls, data: bytes, *_: Any, **__: Any) -> Self:
        """Return the message of CDR with its encapsulation header, of either byte order."""
        reader = _CdrReader(data)
        stamp = Time(*reader.get("iI"))
        header = Header(stamp, reader.text())
        height, width = reader.get("II")
        encoding = reader.text()
        (bigendian,) = reader.get("B")
        step, count = reader.get("II")
        pixels = bytes(reader.data[reader.place : reader.place + count])
        return cls(header, height, width, encoding, bigendian, step, pixels)


@dataclass
@final
class CameraRegions(IdlStruct, typename="cbdsl_msgs::msg::dds_::Regions_"):
    """Segmented regions of an image, as JSON: no common package of ROS has their moments."""

    header: Header = field(default_factory=Header)
    regions: str = ""


@dataclass
@final
class Uuid(IdlStruct, typename="unique_identifier_msgs::msg::dds_::UUID_"):
    """Identifier of a goal."""

    uuid: array[uint8, 16] = field(default_factory=lambda: [0] * 16)


@dataclass
@final
class GoalInfo(IdlStruct, typename="action_msgs::msg::dds_::GoalInfo_"):
    """Identifier of a goal, and the time of its acceptance."""

    goal_id: Uuid = field(default_factory=Uuid)
    stamp: Time = field(default_factory=Time)


@dataclass
@final
class GoalStatus(IdlStruct, typename="action_msgs::msg::dds_::GoalStatus_"):
    """State of a goal, such as 2 while it is executed."""

    goal_info: GoalInfo = field(default_factory=GoalInfo)
    status: int8 = 0


@dataclass
@final
class GoalStatusArray(IdlStruct, typename="action_msgs::msg::dds_::GoalStatusArray_"):
    """States of all goals that the server of an action keeps."""

    status_list: sequence[GoalStatus] = field(default_factory=list)


class _CdrWriter:
    """Little-endian CDR: each number stands at a multiple of its size."""

    def __init__(self) -> None:
        self.data = bytearray()

    def put(self, kinds: str, *values: int) -> None:
        for kind, value in zip(kinds, values, strict=True):
            # Padding to a multiple of the number's size, counted from the end of the encapsulation
            # header.
            self.data.extend(b"\0" * (-len(self.data) % struct.calcsize(kind)))
            self.data.extend(struct.pack(f"<{kind}", value))

    def text(self, text: str) -> None:
        encoded = text.encode() + b"\0"
        self.put("I", len(encoded))
        self.data.extend(encoded)


class _CdrReader:
    """CDR of the byte order that its encapsulation header states."""

    def __init__(self, data: bytes) -> None:
        # The second byte of the encapsulation header is 1 for little-endian CDR, and 0 for
        # big-endian.
        self._order = "<" if data[1] & 1 else ">"
        self.data, self.place = memoryview(data)[4:], 0

    def get(self, kinds: str) -> list[int]:
        values: list[int] = []
        for kind in kinds:
            size = struct.calcsize(kind)
            self.place += -self.place % size
            values.extend(struct.unpack_from(self._order + kind, self.data, self.place))
            self.place += size
        return values

    def text(self) -> str:
        (size,) = self.get("I")
        text = bytes(self.data[self.place : self.place + max(size - 1, 0)]).decode()
        self.place += size
        return text


def type_name(message: type[Any]) -> str:
    """Return the name of a message type as ROS writes it, such as ``sensor_msgs/msg/Image``."""
    return ros_type(str(message.__idl__.idl_transformed_typename.replace(".", "::")))


def ros_type(dds: str) -> str:
    """Return the name of a type of DDS as ROS writes it."""
    return dds.replace("::dds_::", "::").removesuffix("_").replace("::", "/")
