"""MCAP files of ROS 2 messages, read back with rosbags and with Foxglove's decoder."""

from __future__ import annotations

import dataclasses
import json
from collections import defaultdict
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.reporting.recorded import Recorded
from cbdsl.sensing.vision.regions.camera import sight
from tests.cli.test_main import cb
from tests.conftest import ROOT

pytest.importorskip("rosbags")
pytest.importorskip("mcap_ros2")
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from cbdsl_ros2.export.file import write_ros2_mcap

Messages = dict[str, list[tuple[int, Any]]]

TYPES = {
    "/robot_description": "std_msgs/msg/String",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/joint_states": "sensor_msgs/msg/JointState",
    "/joint_references": "sensor_msgs/msg/JointState",
    "/camera/left/image_raw": "sensor_msgs/msg/Image",
    "/camera/left/camera_info": "sensor_msgs/msg/CameraInfo",
    "/wrench/right_hand/finger_1": "geometry_msgs/msg/WrenchStamped",
    "/potentials/approach": "std_msgs/msg/Float64",
    "/predicates/searchtrack/track": "std_msgs/msg/String",
    "/objects": "visualization_msgs/msg/MarkerArray",
    "/rosout": "rcl_interfaces/msg/Log",
}


@pytest.fixture(scope="module")
def file(recorded: Recorded, tmp_path_factory: pytest.TempPathFactory) -> Path:
    target = tmp_path_factory.mktemp("bag") / "episode.mcap"
    count = write_ros2_mcap(recorded, target)
    assert count == sum(map(len, read(target).values()))
    return target


@pytest.fixture(scope="module")
def messages(file: Path) -> Messages:
    return read(file)


def read(file: Path) -> Messages:
    """Return messages by topic, which rosbags reads by the definitions in the file alone."""
    by_topic: Messages = defaultdict(list)
    with AnyReader([file]) as reader:
        for connection, time, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            by_topic[connection.topic].append((time, message))
    return by_topic


def plain(message: Any) -> Any:
    """Return fields of a message of either library as lists, dictionaries and numbers."""
    if dataclasses.is_dataclass(message):
        names = [f.name for f in dataclasses.fields(message) if not f.name.isupper()]
        return {name: plain(getattr(message, name)) for name in names if name != "__msgtype__"}
    if hasattr(message, "__slots__") and not isinstance(message, (np.ndarray, bytes, str)):
        return {name: plain(getattr(message, name)) for name in message.__slots__}
    if isinstance(message, np.ndarray | bytes | bytearray | memoryview):
        return list(message)
    if isinstance(message, list):
        return [plain(item) for item in message]
    return message


def test_file_has_topics_of_documented_types(file: Path) -> None:
    with AnyReader([file]) as reader:
        found = {connection.topic: connection.msgtype for connection in reader.connections}
    assert TYPES.items() <= found.items()


def test_foxglove_decodes_every_message_as_rosbags_does(messages: Messages, file: Path) -> None:
    decoded: Messages = defaultdict(list)
    with file.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, message, content in reader.iter_decoded_messages():
            decoded[channel.topic].append((message.log_time, content))
    assert decoded.keys() == messages.keys()
    for topic, stamped in messages.items():
        assert [time for time, _ in decoded[topic]] == [time for time, _ in stamped]
        # For long topics: the first message, the last and one between.
        for index in {0, len(stamped) // 2, len(stamped) - 1}:
            assert plain(decoded[topic][index][1]) == plain(stamped[index][1]), topic


def test_joint_states_are_the_recorded_ones(messages: Messages, recorded: Recorded) -> None:
    times = recorded.arrays["time"]
    states = messages["/joint_states"]
    assert [time for time, _ in states] == [round(time * 1e9) for time in times.tolist()]
    for index, (time, state) in enumerate(states):
        assert state.header.stamp.sec * 10**9 + state.header.stamp.nanosec == time
        assert state.name == recorded.summary["joints"]
        assert np.array_equal(state.position, recorded.arrays["positions"][index])
        assert np.array_equal(state.velocity, recorded.arrays["velocities"][index])
        assert len(state.effort) == 0
    references = [message.position for _, message in messages["/joint_references"]]
    assert np.array_equal(references, recorded.arrays["references"])


def test_images_and_intrinsics_agree_with_the_camera(
    messages: Messages, recorded: Recorded, dexter: RobotDocument
) -> None:
    images = messages["/camera/left/image_raw"]
    infos = messages["/camera/left/camera_info"]
    assert len(images) == len(infos) == len(recorded.arrays["image_time"]) > 0
    for (_, image), kept in zip(images, recorded.arrays["image_left"], strict=True):
        assert image.encoding == "rgb8" and image.step == 3 * image.width
        assert np.array_equal(image.data.reshape(image.height, image.width, 3), kept)
    _, info = infos[-1]
    assert (info.height, info.width) == recorded.arrays["image_left"].shape[1:3]
    camera, back = dexter.cameras["left"], np.linalg.inv(info.k.reshape(3, 3))
    scale = camera.width / info.width
    for u, v in [(0, 0), (info.width - 1, 0), (3, 7), (info.width / 2, info.height / 2)]:
        right, down, forward = back @ (u, v, 1.0)
        seen = sight(camera, (u + 0.5) * scale, (v + 0.5) * scale)
        assert np.array([forward, -right, -down]) == pytest.approx(seen)


def poses(messages: Messages, index: int) -> dict[str, pinocchio.SE3]:
    """Return the world poses of all frames at a tick."""
    (_, fixed), (_, moving) = messages["/tf_static"][0], messages["/tf"][index]
    above = {each.child_frame_id: each for each in [*fixed.transforms, *moving.transforms]}

    def pose(frame: str) -> pinocchio.SE3:
        if frame == "world":
            return pinocchio.SE3.Identity()
        step = above[frame].transform
        turn = pinocchio.Quaternion(np.array([getattr(step.rotation, axis) for axis in "xyzw"]))
        place = np.array([getattr(step.translation, axis) for axis in "xyz"])
        return pose(above[frame].header.frame_id) * pinocchio.SE3(turn.matrix(), place)

    return {frame: pose(frame) for frame in above}


def test_frames_are_those_of_another_library(messages: Messages, recorded: Recorded) -> None:
    found = poses(messages, -1)
    model = pinocchio.buildModelFromUrdf(str(ROOT / "robots" / "dexter.urdf"))
    posture, data = pinocchio.neutral(model), model.createData()
    joints = dict(zip(recorded.summary["joints"], recorded.arrays["positions"][-1], strict=True))
    couplings = recorded.summary["robot"]["couplings"]
    joints |= {name: ratio * joints[follows] for name, (follows, ratio) in couplings.items()}
    for name, position in joints.items():
        posture[model.joints[model.getJointId(name)].idx_q] = position
    pinocchio.framesForwardKinematics(model, data, posture)
    compared = [frame for frame in found if model.existBodyName(frame)]
    assert len(compared) == sum(frame.type == pinocchio.BODY for frame in model.frames)
    for frame in compared:
        error = found[frame].homogeneous - data.oMf[model.getBodyId(frame)].homogeneous
        assert abs(error).max() < 1e-9, frame


def test_optical_frames_look_along_z_with_x_to_the_right(
    messages: Messages, dexter: RobotDocument
) -> None:
    found = poses(messages, 0)
    for name, camera in dexter.cameras.items():
        link, optical = found[camera.link], found[f"{name}_optical_frame"]
        forward, left, up = link.rotation.T
        right, down, ahead = optical.rotation.T
        assert [*right, *down, *ahead] == pytest.approx([*-left, *-up, *forward])
        assert optical.translation == pytest.approx(link.translation)


def test_corrected_camera_is_displaced_and_turned(recorded: Recorded, tmp_path: Path) -> None:
    summary = json.loads(json.dumps(recorded.summary))
    correction = {"position": [0.01, 0.02, 0.03], "rotation": [0.0, 0.0, 0.1]}
    summary["robot"]["cameras"]["left"]["correction"] = correction
    write_ros2_mcap(replace(recorded, summary=summary), tmp_path / "bag.mcap")
    found = poses(read(tmp_path / "bag.mcap"), 0)
    link = found[summary["robot"]["cameras"]["left"]["link"]]
    step = link.inverse() * found["left_optical_frame"]
    assert step.translation == pytest.approx([0.01, 0.02, 0.03])
    assert step.rotation[:, 2] == pytest.approx([np.cos(0.1), np.sin(0.1), 0.0])


def test_wrenches_are_the_recorded_loads_in_the_axes_of_their_links(
    messages: Messages, recorded: Recorded, dexter: RobotDocument
) -> None:
    loads = recorded.arrays["loads"]
    index = int(np.argmax(abs(loads[:, :, :3]).max(axis=(1, 2))))
    found = poses(messages, index)
    assert abs(loads[index]).max() > 0.1, "something is felt"
    for column, name in enumerate(recorded.summary["load_cells"]):
        hand, finger = name.split(".")
        _, message = messages[f"/wrench/{hand}/{finger}"][index]
        link = message.header.frame_id
        assert link == dexter.load_cells[hand][finger].link
        wrench = message.wrench
        parts = [[getattr(part, a) for a in "xyz"] for part in (wrench.force, wrench.torque)]
        world = [found[link].rotation @ part for part in parts]
        assert np.concatenate(world) == pytest.approx(loads[index, column], abs=1e-9)


def test_potentials_and_predicates_are_there_while_they_are_defined(
    messages: Messages, recorded: Recorded
) -> None:
    for column, name in enumerate(recorded.controllers):
        topic = name.replace(".", "/")
        letters = [message.data for _, message in messages[f"/predicates/{topic}"]]
        assert letters == [each[column] for each in recorded.summary["predicates"]]
        values = recorded.arrays["potentials"][:, column]
        kept = [message.data for _, message in messages.get(f"/potentials/{topic}", [])]
        assert kept == values[~np.isnan(values)].tolist()
    lines = [message.msg for _, message in messages["/rosout"]]
    words = [each["words"] for each in recorded.transitions]
    assert any(words)
    assert all(own in line for own, line in zip(words, lines[:-1], strict=True))
    assert lines[-1] == recorded.summary["result"]["ending"]


def test_markers_hang_on_frames_of_objects(messages: Messages, recorded: Recorded) -> None:
    (_, shown), found = messages["/objects"][0], poses(messages, 0)
    assert {marker.ns for marker in shown.markers} == set(recorded.summary["scene"]) != set()
    for marker in shown.markers:
        assert marker.header.frame_id in found
    ball = shown.markers[0]
    assert (ball.type, ball.scale.x) == (ball.SPHERE, pytest.approx(0.14))


def test_recording_without_cameras_cells_and_velocities_is_exported(
    recorded: Recorded, tmp_path: Path
) -> None:
    """Recordings of earlier versions lack cameras, load cells and velocities."""
    summary = json.loads(json.dumps(recorded.summary))
    del summary["robot"]["cameras"], summary["robot"]["cells"]
    arrays = {key: array for key, array in recorded.arrays.items() if key != "velocities"}
    write_ros2_mcap(replace(recorded, summary=summary, arrays=arrays), tmp_path / "bag.mcap")
    found = read(tmp_path / "bag.mcap")
    assert "/camera/left/camera_info" not in found and found["/camera/left/image_raw"]
    _, wrench = found["/wrench/right_hand/finger_1"][0]
    assert wrench.header.frame_id == "world"
    assert len(found["/joint_states"][0][1].velocity) == 0


def test_latched_topics_reach_late_subscribers(file: Path) -> None:
    with AnyReader([file]) as reader:
        quality = {c.topic: c.ext.offered_qos_profiles for c in reader.connections}
    (latched,) = quality["/tf_static"]
    assert latched.durability.name == "TRANSIENT_LOCAL" and latched.history.name == "KEEP_LAST"
    assert not quality["/tf"]


def test_export_command_writes_messages_of_ros2(
    kept: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = tmp_path / "e.mcap"
    assert cb(monkeypatch, "export", "ros2", str(kept), "--out", str(out)) == 0
    assert "messages" in capsys.readouterr().out
    assert read(out)["/joint_states"]
    nowhere = str(tmp_path / "none" / "e.mcap")
    assert cb(monkeypatch, "export", "ros2", str(kept), "--out", nowhere) == 2
    assert f"{nowhere}: No such file" in capsys.readouterr().err
