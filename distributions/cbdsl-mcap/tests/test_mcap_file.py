"""MCAP files, read back with the library: frames, joints, images, predicates and transitions."""

from __future__ import annotations

import base64
import json
from collections import defaultdict
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pinocchio
import pytest
from jsonschema import Draft202012Validator

from cbdsl.reporting.recorded import Recorded, read_recording
from tests.cli.test_main import cb
from tests.conftest import ROOT

pytest.importorskip("mcap")
from mcap.reader import make_reader

from cbdsl_mcap.mcap_file import write_mcap

Messages = dict[str, list[tuple[int, dict[str, Any]]]]
SEED = 3_700_000


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    """Record an episode of a head and an arm, and add images."""
    folder = tmp_path_factory.mktemp("tapes")
    with pytest.MonkeyPatch.context() as patch:
        words = ("run", "reachtouch", "--backend", "kinematic", "--seed", str(SEED))
        assert cb(patch, *words, "--record", str(folder)) == 0
    found = read_recording(folder / f"episode_{SEED}.json")
    rng = np.random.default_rng(3)
    images = rng.integers(0, 255, (2, 12, 16, 3), dtype=np.uint8)
    arrays = {**found.arrays, "image_left": images, "image_time": np.array([0.0, 0.5])}
    return replace(found, arrays=arrays)


@pytest.fixture(scope="module")
def file(recorded: Recorded, tmp_path_factory: pytest.TempPathFactory) -> Path:
    target = tmp_path_factory.mktemp("mcap") / "episode.mcap"
    count = write_mcap(recorded, target)
    assert count == sum(map(len, read(target).values()))
    return target


def read(file: Path) -> Messages:
    """Return messages by topic, checked against their schemas, with their time stamps."""
    by_topic: Messages = defaultdict(list)
    with file.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            content = json.loads(message.data)
            assert schema is not None and schema.encoding == "jsonschema"
            Draft202012Validator(json.loads(schema.data)).validate(content)
            by_topic[channel.topic].append((message.log_time, content))
    return by_topic


def test_file_has_a_message_per_tick_on_each_topic(file: Path, recorded: Recorded) -> None:
    messages = read(file)
    ticks = len(recorded.arrays["time"])
    each_tick = ("/tf", "/joint_states", "/potentials", "/predicates", "/signals")
    assert {topic: len(messages[topic]) for topic in each_tick} == dict.fromkeys(each_tick, ticks)
    assert [time for time, _ in messages["/tf"]] == [
        round(time * 1e9) for time in recorded.arrays["time"].tolist()
    ]
    _, joints = messages["/joint_states"][-1]
    assert joints["names"] == recorded.summary["joints"]
    assert joints["positions"] == recorded.arrays["positions"][-1].tolist()
    _, last = messages["/predicates"][-1]
    assert "".join(last["predicates"].values()) == recorded.summary["predicates"][-1]
    lines = [content["message"] for _, content in messages["/transitions"]]
    words = [each["words"] for each in recorded.transitions]
    assert any(" -> " in each for each in words)
    assert all(own in line for own, line in zip(words, lines[:-1], strict=True))
    assert lines[-1] == recorded.summary["result"]["ending"]
    first = messages["/potentials"][0][1]["values"]
    assert None in first.values(), "what is undefined has no number"


def test_images_are_those_that_were_recorded(file: Path, recorded: Recorded) -> None:
    kept = read(file)["/camera/left"]
    assert [time for time, _ in kept] == [0, 500_000_000]
    for (_, content), image in zip(kept, recorded.arrays["image_left"], strict=True):
        data = np.frombuffer(base64.b64decode(content["data"]), dtype=np.uint8)
        assert (cv2.cvtColor(cv2.imdecode(data, 1), cv2.COLOR_BGR2RGB) == image).all()


def test_frames_agree_with_pinocchio(file: Path, recorded: Recorded) -> None:
    """Transforms of each link at the end agree with Pinocchio's."""
    _, content = read(file)["/tf"][-1]
    above = {each["child_frame_id"]: each for each in content["transforms"]}
    model = pinocchio.buildModelFromUrdf(str(ROOT / "robots" / "dexter.urdf"))
    posture, data = pinocchio.neutral(model), model.createData()
    joints = dict(zip(recorded.summary["joints"], recorded.arrays["positions"][-1], strict=True))
    couplings = recorded.summary["robot"]["couplings"]
    joints |= {name: ratio * joints[follows] for name, (follows, ratio) in couplings.items()}
    for name, position in joints.items():
        posture[model.joints[model.getJointId(name)].idx_q] = position
    pinocchio.framesForwardKinematics(model, data, posture)

    def pose(frame: str) -> pinocchio.SE3:
        if frame == "world":
            return pinocchio.SE3.Identity()
        link = above[frame]
        turn = pinocchio.Quaternion(np.array([link["rotation"][key] for key in "xyzw"]))
        place = np.array([link["translation"][key] for key in "xyz"])
        return pose(link["parent_frame_id"]) * pinocchio.SE3(turn.matrix(), place)

    compared = 0
    for frame in above:
        if model.existBodyName(frame):
            error = pose(frame).homogeneous - data.oMf[model.getBodyId(frame)].homogeneous
            assert abs(error).max() < 1e-9, frame
            compared += 1
    assert compared > 20


def test_shapes_hang_on_frames_that_there_are(file: Path, recorded: Recorded) -> None:
    messages = read(file)
    frames = {each["child_frame_id"] for each in messages["/tf"][0][1]["transforms"]}
    robot, things = (messages[topic][0][1]["entities"] for topic in ("/robot", "/things"))
    assert {entity["frame_id"] for entity in [*robot, *things]} <= frames
    assert {entity["id"] for entity in things} == {f"thing/{n}" for n in recorded.summary["scene"]}
    kinds = ("cubes", "spheres", "cylinders", "triangles")
    assert sum(len(entity[kind]) for entity in robot for kind in kinds) > 20
    assert all(any(entity[kind] for kind in kinds) for entity in things)


def test_model_and_the_result_are_kept(file: Path, recorded: Recorded) -> None:
    with file.open("rb") as stream:
        reader = make_reader(stream)
        (attachment,) = reader.iter_attachments()
        (metadata,) = reader.iter_metadata()
    assert attachment.name == "dexter.urdf"
    assert attachment.data.decode() == recorded.summary["robot"]["urdf"]
    assert metadata.metadata["seed"] == str(SEED)


def test_command_writes_a_file_beside_each_recording(
    recorded: Recorded, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = recorded.file.parent
    assert cb(monkeypatch, "export", "mcap", str(folder)) == 0
    assert f"episode_{SEED}.mcap" in capsys.readouterr().out
    assert read(folder / f"episode_{SEED}.mcap")["/joint_states"]
    assert cb(monkeypatch, "export", "mcap", str(folder / "nothing")) == 2


def test_schemas_option_writes_messages_of_ros2_and_names_unknown_schemas(
    recorded: Recorded,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    words = ("export", "mcap", str(recorded.file), "--schemas")
    assert cb(monkeypatch, *words, "ros2", "--out", str(tmp_path / "bag.mcap")) == 0
    with (tmp_path / "bag.mcap").open("rb") as stream:
        assert {s.encoding for s, _, _ in make_reader(stream).iter_messages() if s} == {"ros2msg"}
    capsys.readouterr()
    assert cb(monkeypatch, *words, "ros") == 2
    assert "did you mean 'ros2'" in capsys.readouterr().err
