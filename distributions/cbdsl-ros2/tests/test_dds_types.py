"""Messages: names and bytes of ROS 2."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("cyclonedds")

from cyclonedds.idl import IdlStruct

from cbdsl_ros2 import dds_types as msg

STAMP = msg.Time(1_700_000_000, 250_000_000)
HEADER = msg.Header(STAMP, "palm")
POINT = msg.JointTrajectoryPoint(positions=[1.5, -2.5], time_from_start=msg.Duration(0, 50_000_000))
EXAMPLES: dict[str, Any] = {
    "std_msgs/msg/String": msg.Text("<robot/>"),
    "std_msgs/msg/Bool": msg.Flag(True),
    "std_msgs/msg/Float64MultiArray": msg.Float64MultiArray(data=[1.0, 2.0]),
    "sensor_msgs/msg/JointState": msg.JointState(HEADER, ["a", "bcd"], [1.0, 2.0], [], [3.0, 4.0]),
    "geometry_msgs/msg/WrenchStamped": msg.WrenchStamped(
        HEADER, msg.Wrench(msg.Vector3(1.0, 2.0, 3.0), msg.Vector3(4.0, 5.0, 6.0))
    ),
    "trajectory_msgs/msg/JointTrajectory": msg.JointTrajectory(HEADER, ["a", "bcd"], [POINT]),
    "sensor_msgs/msg/Image": msg.Image(HEADER, 2, 1, "rgb8", 0, 3, bytes(range(6))),
    "sensor_msgs/msg/CameraInfo": msg.CameraInfo(
        HEADER, 2, 1, "plumb_bob", [0.0] * 5, [float(i) for i in range(9)]
    ),
    "action_msgs/msg/GoalStatusArray": msg.GoalStatusArray(
        [
            msg.GoalStatus(msg.GoalInfo(msg.Uuid(list(range(16))), STAMP), status)
            for status in (2, 4)
        ]
    ),
}


@pytest.mark.parametrize("name", EXAMPLES)
def test_message_has_the_name_of_ros(name: str) -> None:
    assert msg.type_name(type(EXAMPLES[name])) == name


@pytest.mark.parametrize("name", EXAMPLES)
def test_message_has_the_bytes_of_an_independent_encoder(name: str) -> None:
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    message = EXAMPLES[name]
    decoded = store.deserialize_cdr(message.serialize(), name)
    assert bytes(store.serialize_cdr(decoded, name)).rstrip(b"\0") == message.serialize().rstrip(
        b"\0"
    )
    for field in dataclasses.fields(message):
        value = getattr(decoded, field.name)
        if isinstance(getattr(message, field.name), str):
            assert value == getattr(message, field.name)


@given(st.text(st.characters(codec="ascii", exclude_characters="\0")), st.binary(max_size=40))
def test_image_has_the_bytes_of_the_generic_encoder(frame: str, data: bytes) -> None:
    image = msg.Image(msg.Header(STAMP, frame), 3, 2, "rgb8", 0, 6, data)
    assert image.serialize() == IdlStruct.serialize(image)
    assert msg.Image.deserialize(image.serialize()) == image


@given(st.floats(0.0, 4e9))
def test_time_keeps_seconds(seconds: float) -> None:
    time = msg.Time.of(seconds)
    assert 0 <= time.nanosec < 1_000_000_000
    assert time.seconds == pytest.approx(seconds, abs=1e-6)
