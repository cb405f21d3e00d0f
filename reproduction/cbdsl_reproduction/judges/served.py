"""Success on a served robot, beside that of the same seeds in process.

A second process simulates the robot in real time behind the topics of its drivers. The robot's own
sensors decide on the reward.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from importlib.util import find_spec
from multiprocessing import get_context
from multiprocessing.synchronize import Event
from typing import cast

from cbdsl import RunRequest, UsageError
from cbdsl.api.control import Kinematics
from cbdsl.api.sensing import EpisodeListeners, Runner, Tick
from cbdsl.api.shipped import shipped_program
from cbdsl.api.simulation.rehearsal import rehearse
from cbdsl.api.trials import AttendedBackend, Backend, embody
from cbdsl_reproduction.judges.judge import ANY, BodyChoice, EpisodeVerdict, Judge, JudgedCondition

_PROGRAMS = ("reachtouch", "visualinspect", "pick_and_place")
_IN_PROCESS, _SERVED = "in process", "served"
# ROS 2 domains of parallel processes, apart from the default one.
_FIRST_DOMAIN, _DOMAINS = 101, 100
# Time for the start and for the end of a server, s.
_PATIENCE = 60.0


class SimulationConsent:
    """Consent to move a robot that is simulated; never to the release of a held one."""

    def confirm(self, text: str, question: str, *, released: bool) -> bool:
        """Agree to the questions that a consent in advance may answer."""
        return released


def _serve(robot: str, stage: str, body: BodyChoice, seed: int, ready: Event, stop: Event) -> None:
    """Serve a simulated robot, in a process of its own."""
    from cbdsl_ros2.serve import serve_robot

    serve_robot(
        robot,
        backend=body.backend,
        stage=stage,
        seed=seed,
        cameras=body.cameras,
        report=lambda line: ready.set(),
        stopped=stop.is_set,
    )


@contextmanager
def _served(request: RunRequest, body: BodyChoice, seed: int) -> Iterator[None]:
    """Serve the robot on the program's stage until the block ends."""
    context = get_context("spawn")
    ready, stop = context.Event(), context.Event()
    names = request.robot.name, request.stage.name
    process = context.Process(target=_serve, args=(*names, body, seed, ready, stop), daemon=True)
    process.start()
    try:
        ready.wait(_PATIENCE)
        yield
    finally:
        stop.set()
        process.join(_PATIENCE)


class LoadMeter:
    """Share of a processor that this process uses from the first tick on."""

    def __init__(self) -> None:
        self._begun: tuple[float, float] | None = None

    def note(self, tick: Tick) -> None:
        """Begin at the first tick."""
        if self._begun is None:
            self._begun = time.process_time(), time.monotonic()

    def percent(self) -> float:
        """Return the share, %; 0 without a tick."""
        if self._begun is None:
            return 0.0
        processor, wall = self._begun
        return 100 * (time.process_time() - processor) / max(time.monotonic() - wall, 1e-3)


def _episode(request: RunRequest, backend: Backend, seed: int) -> EpisodeVerdict:
    """Run one episode; a hold of the robot ends it without reward."""
    meter = LoadMeter()
    kinematics = Kinematics(request.robot, request.urdf)
    runner = Runner(request.robot, kinematics, request.program, backend)
    try:
        result = runner.run(request.stage, seed, observer=EpisodeListeners(on_tick=meter.note))
    except UsageError as error:
        return EpisodeVerdict(seed, {"rewarded": False}, 0.0, str(error))
    outcomes = {"rewarded": result.rewarded}
    measures = {"load_percent": meter.percent()}
    return EpisodeVerdict(seed, outcomes, result.sim_seconds, result.ending, measures)


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each episode, in process or on a served robot."""
    request = shipped_program(condition.program)
    robot, urdf = request.robot, request.urdf
    if condition.name.endswith(_IN_PROCESS):
        with closing(embody(body.backend, robot, urdf, cameras=body.cameras)) as own:
            for seed in seeds:
                yield _episode(request, own, seed)
        return
    if find_spec("cbdsl_ros2") is None:
        raise UsageError("served robots come with cbdsl[ros2]: pip install 'cbdsl[ros2]'")
    # Loading machine code within a control tick would break the robot's deadline.
    rehearse(request)
    # In a common domain, a process would receive the states of robots that other processes serve.
    os.environ.setdefault("ROS_DOMAIN_ID", str(_FIRST_DOMAIN + os.getpid() % _DOMAINS))
    # The server sets up the stage by its seed, so that each episode has a server of its own.
    for seed in seeds:
        with (
            _served(request, body, seed),
            closing(embody("ros2", robot, urdf, cameras=body.cameras)) as driven,
        ):
            cast(AttendedBackend, driven).attend(SimulationConsent())
            yield _episode(request, driven, seed)


JUDGE = Judge(
    "served",
    "success on a served robot, in real time by ROS 2, and in process",
    tuple(
        JudgedCondition(f"{program}, {where}", program, {"rewarded": ANY})
        for program in _PROGRAMS
        for where in (_IN_PROCESS, _SERVED)
    ),
    _measure,
    BodyChoice("mujoco", "ideal"),
)
