"""Stage requests: a program asks a served robot for the stage of its next episode.

Both topics carry JSON as ``std_msgs/String``. A request is repeated until its answer arrives, since
messages may be lost; requests of one number are one.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from cbdsl.extend.backend import MeshForm, StageDocument, UsageError
from cbdsl.extend.driver import Setup
from cbdsl_ros2 import dds_types as msg
from cbdsl_ros2.ros_node import RosNode

REQUESTS, ANSWERS = "/cbdsl/setup", "/cbdsl/setup/answer"
_MOST = 64


class StageAsker:
    """Program's side.

    Args:
        node: Node of the program.
    """

    def __init__(self, node: RosNode) -> None:
        self._node = node
        self._setup: Setup | None = None
        self._number, self._text = "", ""
        self._answers: Any = node.reader(ANSWERS, msg.Text, reliable=True)
        self._requests: Any = None

    @property
    def is_heard(self) -> bool:
        """True if a served robot listens."""
        return any(r.topic == REQUESTS and not r.writes for r in self._node.remotes())

    def ask(self, setup: Setup) -> None:
        """Send a request, or repeat it."""
        if setup is not self._setup:
            self._setup, self._number = setup, f"{os.getpid()}-{time.time_ns()}"
            self._text = _written(setup, self._number)
        if self._requests is None:
            self._requests = self._node.writer(REQUESTS, msg.Text)
        self._requests.write(msg.Text(self._text))

    def answer(self) -> str | None:
        """Return the answer to the newest request, if it has arrived."""
        for message in self._answers.take(_MOST):
            if message.sample_info.valid_data:
                answer = json.loads(message.data)
                if answer["number"] == self._number:
                    return str(answer["problem"])
        return None


class StageSetter:
    """Served robot's side.

    Args:
        node: Node of the served robot.
        robot: Name of the robot.
    """

    def __init__(self, node: RosNode, robot: str) -> None:
        self._robot = robot
        self._requests: Any = node.reader(REQUESTS, msg.Text, reliable=True)
        self._answers: Any = node.writer(ANSWERS, msg.Text)
        # Number of the newest request, and its answer.
        self._done: tuple[str, str] | None = None

    def attend(self, set_up: Callable[[Setup], None]) -> None:
        """Answer the newest request.

        Args:
            set_up: Function that sets up a stage, or raises ``UsageError``.
        """
        texts = [m.data for m in self._requests.take(_MOST) if m.sample_info.valid_data]
        if not texts:
            return
        try:
            request = json.loads(texts[-1])
            number = str(request["number"])
            if request["robot"] != self._robot:
                return
        except (ValueError, KeyError, TypeError):
            return
        if self._done is None or self._done[0] != number:
            self._done = number, _problem(request, set_up)
        answer = {"number": number, "problem": self._done[1]}
        self._answers.write(msg.Text(json.dumps(answer)))


def generator(setup: Setup) -> np.random.Generator:
    """Return the episode's generator before its first draw."""
    rng = np.random.default_rng()
    rng.bit_generator.state = dict(setup.draws)
    return rng


def _written(setup: Setup, number: str) -> str:
    """Return a request as JSON; meshes have absolute paths."""
    stage = setup.stage.model_dump(mode="json")
    for section in ("things", "fixtures"):
        for name, item in getattr(setup.stage, section).items():
            if isinstance(item.form, MeshForm):
                stage[section][name]["form"]["file"] = str(item.form.path.absolute())
    request = {"number": number, "robot": setup.robot, "stage": stage}
    return json.dumps({**request, "context": setup.context, "draws": setup.draws})


def _problem(request: dict[str, Any], set_up: Callable[[Setup], None]) -> str:
    """Set up a requested stage; return the reason if that fails."""
    try:
        stage = StageDocument.model_validate(request["stage"])
        set_up(Setup(request["robot"], stage, request["context"], request["draws"]))
    except UsageError as error:
        return str(error)
    except (ValueError, KeyError, TypeError) as error:
        return f"the request cannot be read: {error}"
    return ""
