"""Success of programs over roles in tasks of robosuite, by the tasks' own tests of success.

Robosuite simulates in a process and a Python environment of its own. No program sees a pose of its
simulation: the robot has encoders, load cells in its pads, and a pair of cameras.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path

from cbdsl import UsageError, load
from cbdsl.api.control import Kinematics
from cbdsl.api.open_robot import OpenRobot
from cbdsl_reproduction.judges.judge import (
    ANY,
    NONE,
    Aim,
    BodyChoice,
    EpisodeVerdict,
    Judge,
    JudgedCondition,
)
from cbdsl_reproduction.worlds.camera_pair import looking_at
from cbdsl_reproduction.worlds.robosuite_backend import RobosuiteBackend
from cbdsl_reproduction.worlds.robosuite_process import RobosuiteProcess
from cbdsl_reproduction.worlds.robosuite_robot import RATE, write_robot
from cbdsl_reproduction.worlds.robosuite_task import ARMS, TASKS

_BACKEND = "robosuite"


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict of the task on each episode.

    Raises:
        UsageError: There is no environment of robosuite, or another backend is requested.
    """
    if body.backend != _BACKEND:
        raise UsageError("the judge 'robosuite' judges in its own simulation; leave out --backend")
    task_name, arm = condition.name.split(", ")
    task, pair = TASKS[task_name], looking_at(TASKS[task_name].middle)
    places = {name: place._asdict() for name, place in pair.places.items()}
    view = pair.width, pair.height, pair.vertical_angle
    with (
        tempfile.TemporaryDirectory() as folder,
        closing(RobosuiteProcess(task.name, [arm] * task.arms, RATE, places, view)) as process,
    ):
        name = f"robosuite_{arm.lower()}"
        write_robot(name, process, pair, Path(folder))
        request = load(task.program, values={"robot": name}, folder=Path(folder))
        backend = RobosuiteBackend(
            request.robot, process, pair, task.features, body.cameras or "ideal"
        )
        robot = OpenRobot(request, backend, Kinematics(request.robot, request.urdf))
        for seed in seeds:
            result = robot.run(seed)
            reported = result.outcome == "success"
            outcomes = {
                "success": backend.succeeded,
                "success at any time": backend.ever_succeeded,
                "reported without success": reported and not backend.succeeded,
            }
            yield EpisodeVerdict(seed, outcomes, result.sim_seconds, result.ending)


JUDGE = Judge(
    "robosuite",
    "tasks of robosuite with programs over roles, by the tasks' own tests of success",
    tuple(
        JudgedCondition(
            f"{task.name}, {arm}",
            "",
            {
                "success": Aim(task.least),
                "success at any time": ANY,
                "reported without success": NONE,
            },
        )
        for task in TASKS.values()
        for arm in ARMS
    ),
    _measure,
    BodyChoice(_BACKEND, "ideal"),
    folder="worlds",
)
