"""Stage requests: a program and a served robot, over DDS."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("cyclonedds")

from cbdsl.backends.backend import BackendError
from cbdsl.documents.stage import StageDocument
from cbdsl.extend.driver import Setup
from cbdsl_ros2 import dds_types as msg
from cbdsl_ros2.ros_node import RosNode
from cbdsl_ros2.stage_requests import REQUESTS, StageAsker, StageSetter, generator
from tests.backends.conftest import made_stage, stage_named


def answered(asker: StageAsker, setter: StageSetter, setup: Setup, *problems: str) -> list[Setup]:
    """Exchange messages until the answer arrives; return the stages that were set up."""
    done: list[Setup] = []

    def set_up(request: Setup) -> None:
        done.append(request)
        for problem in problems:
            raise BackendError(problem)

    until = time.monotonic() + 5.0
    answer: str | None = None
    while answer is None and time.monotonic() < until:
        asker.ask(setup)
        time.sleep(0.02)
        setter.attend(set_up)
        answer = asker.answer()
    assert answer == "".join(problems)
    return done


def request(stage: StageDocument, seed: int = 3) -> Setup:
    return Setup("dexter", stage, None, np.random.default_rng([seed, 0]).bit_generator.state)


def test_stage_and_draws_arrive_once_for_many_requests(node: RosNode) -> None:
    asker, setter = StageAsker(node), StageSetter(node, "dexter")
    stage = stage_named("things_and_a_pad")
    for seed in (3, 4):
        (setup,) = answered(asker, setter, request(stage, seed))
        assert setup.stage == stage
        assert generator(setup).integers(2**63) == np.random.default_rng([seed, 0]).integers(2**63)
    assert asker.is_heard


def test_refusal_names_its_reason(node: RosNode) -> None:
    asker, setter = StageAsker(node), StageSetter(node, "dexter")
    answered(asker, setter, request(made_stage({})), "no room on the table")


def test_mesh_of_a_stage_is_found_by_the_served_robot(node: RosNode, tmp_path: Path) -> None:
    form = {"shape": "mesh", "file": "cup.stl"}
    document = made_stage({}).model_dump()
    document["things"] = {"cup": {"form": form, "mass": 0.1}}
    stage = StageDocument.model_validate(document, context={"folder": tmp_path})
    asker, setter = StageAsker(node), StageSetter(node, "dexter")
    (setup,) = answered(asker, setter, request(stage))
    assert setup.stage.things["cup"].form.path == tmp_path / "cup.stl"


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"number": 1, "robot": "other"}'])
def test_request_of_another_robot_or_form_is_ignored(text: str, node: RosNode) -> None:
    setter, writer = StageSetter(node, "dexter"), node.writer(REQUESTS, msg.Text)

    def refuse(setup: Setup) -> None:
        raise AssertionError(setup)

    for _ in range(10):
        writer.write(msg.Text(text))
        time.sleep(0.01)
        setter.attend(refuse)


def test_broken_stage_is_answered(node: RosNode) -> None:
    setter, writer = StageSetter(node, "dexter"), node.writer(REQUESTS, msg.Text)
    asker = StageAsker(node)
    asker._number = "1"
    text = '{"number": "1", "robot": "dexter", "stage": {}, "context": null, "draws": {}}'
    until, answer = time.monotonic() + 5.0, None
    while answer is None and time.monotonic() < until:
        writer.write(msg.Text(text))
        time.sleep(0.02)
        setter.attend(lambda setup: None)
        answer = asker.answer()
    assert answer is not None and answer.startswith("the request cannot be read")
