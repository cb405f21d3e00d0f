"""Success on a served robot, beside that of the same seeds in process, by the documented commands.

``cb drive serve`` simulates the robot in real time, and one ``cb run`` drives it through all
episodes. With Fast DDS, a bridge of rclpy stands between their domains. The robot's own sensors
decide on the reward.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from cbdsl import RunRequest, UsageError
from cbdsl.api.shipped import shipped_program
from cbdsl_reproduction.judges.judge import (
    ANY,
    NONE,
    Aim,
    BodyChoice,
    EpisodeVerdict,
    Judge,
    JudgedCondition,
)

_PROGRAMS = ("reachtouch", "visualinspect", "pick_and_place", "deliver")
_CYCLONE, _FAST = "Cyclone DDS", "rclpy with Fast DDS"
# Borderline episodes differ by chance: the served robot's time is not the program's.
_MOSTLY = Aim(least=0.9)
_CB = (sys.executable, "-c", "from cbdsl.cli.main import main; main()")
# ROS 2 domains of parallel judges, two for each, apart from the default one.
_FIRST_DOMAIN, _PAIRS = 101, 50
# Longest time for the start or the end of a command, and for an episode, s.
_PATIENCE, _EPISODE = 120.0, 180.0
_BRIDGE = Path(__file__).with_name("fast_dds_bridge.py")


class _Ended(NamedTuple):
    """Outcome of an episode: success or reward, simulated time, s, and last words."""

    succeeded: bool
    seconds: float
    ending: str
    held: bool = False


def _environment(domain: int) -> dict[str, str]:
    return {
        **os.environ,
        "ROS_DOMAIN_ID": str(domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    }


@contextmanager
def _process(words: Sequence[str], sign: str, domain: int) -> Iterator[None]:
    """Run a command until the block ends.

    Args:
        words: Command.
        sign: Beginning of the line after which it is ready.
        domain: ROS 2 domain.

    Raises:
        UsageError: It ends, or is not ready in time.
    """
    with tempfile.TemporaryFile("w+") as problems:
        process = subprocess.Popen(
            words, env=_environment(domain), stdout=subprocess.PIPE, stderr=problems, text=True
        )
        watch = threading.Timer(_PATIENCE, process.kill)
        watch.start()
        try:
            assert process.stdout is not None
            if not any(line.startswith(sign) for line in process.stdout):
                problems.seek(0)
                raise UsageError(f"{' '.join(words)}: it is not ready: {problems.read()[-500:]}")
            watch.cancel()
            drain = threading.Thread(target=process.stdout.read, daemon=True)
            drain.start()
            yield
        finally:
            watch.cancel()
            process.send_signal(signal.SIGTERM)
            try:
                process.wait(_PATIENCE)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def _run(
    request: RunRequest, backend: str, cameras: str | None, seeds: range, domain: int = 0
) -> dict[int, _Ended]:
    """Run consecutive episodes by ``cb run``; return the ended ones by seed."""
    options = ["--cameras", cameras] if cameras else []
    if backend == "ros2":
        options.append("--yes")
    words = [
        *_CB, "run", request.program.name, "--backend", backend, *options, "--seed",
        str(seeds.start), "--episodes", str(len(seeds)), "--json",
    ]  # fmt: skip
    try:
        ran = subprocess.run(
            words,
            env=_environment(domain),
            capture_output=True,
            text=True,
            timeout=_PATIENCE + _EPISODE * len(seeds),
        )
        output, problem = ran.stdout, ran.stderr.strip()
    except subprocess.TimeoutExpired as late:
        output, problem = (late.stdout or b"").decode(), "the command did not end"
    rows = [json.loads(line) for line in output.splitlines() if line.startswith("{")]
    ended = {row["seed"]: _ended(row, request) for row in rows}
    # The episode after the last one is that in which the command ended early.
    missing = next((seed for seed in seeds if seed not in ended), None)
    if missing is not None:
        last = problem.splitlines()[-1] if problem else "the command ended"
        ended[missing] = _Ended(False, 0.0, last, held="the robot is held" in problem)
    return ended


def _ended(row: dict[str, Any], request: RunRequest) -> _Ended:
    states = request.program.success
    succeeded = row["outcome"] == "success" if states else row["rewarded"]
    return _Ended(bool(succeeded), row["sim_seconds"], row["ending"])


@contextmanager
def _served(request: RunRequest, body: BodyChoice, domain: int, node: str) -> Iterator[int]:
    """Serve the robot until the block ends; yield the domain in which a program drives it."""
    cameras = ("--cameras", body.cameras) if body.cameras else ()
    serve = (*_CB, "drive", "serve", request.robot.name, "--backend", body.backend, *cameras)
    with _process(serve, "serving", domain):
        if node == _CYCLONE:
            yield domain
            return
        with (
            _process(_bridge(request, (domain, domain + 1)), "ready", domain),
            _relayed_regions(request, (domain, domain + 1)),
        ):
            yield domain + 1


def _bridge(request: RunRequest, domains: tuple[int, int]) -> tuple[str, ...]:
    """Return the command of the bridge.

    Raises:
        UsageError: No interpreter with rclpy is known.
    """
    python = os.environ.get("CB_RCLPY") or "build/rclpy/bin/python"
    if not Path(python).is_file():
        raise UsageError(
            f"{_FAST} needs an interpreter with rclpy, and {python} is none: run 'make rclpy', or "
            "name another one in CB_RCLPY"
        )
    from cbdsl_ros2.stage_requests import ANSWERS, REQUESTS

    out, back = [[ANSWERS, "std_msgs/String", "reliable"]], []
    for driver in request.robot.drivers.values():
        single = {
            "sensor_msgs/JointState": (driver.states, "reliable"),
            "std_msgs/String": (driver.description, "lasting"),
            "std_msgs/Bool": (driver.stop, "lasting"),
        }
        out += [[topic, name, kind] for name, (topic, kind) in single.items() if topic]
        wrenches = [topic for fingers in driver.wrenches.values() for topic in fingers.values()]
        out += [[topic, "geometry_msgs/WrenchStamped", "reliable"] for topic in wrenches]
        out += [[topic, "sensor_msgs/Image", "sensor"] for topic in driver.images.values()]
        infos = driver.camera_info.values()
        out += [[topic, "sensor_msgs/CameraInfo", "reliable"] for topic in infos]
        if driver.commands:
            back.append([driver.commands, "trajectory_msgs/JointTrajectory", "reliable"])
    back.append([REQUESTS, "std_msgs/String", "reliable"])
    return python, str(_BRIDGE), json.dumps({"domains": domains, "out": out, "back": back})


@contextmanager
def _relayed_regions(request: RunRequest, domains: tuple[int, int]) -> Iterator[None]:
    """Forward segmented regions, whose type no package of rclpy has, until the block ends."""
    from cbdsl_ros2 import dds_types as msg
    from cbdsl_ros2.ros_node import RosNode

    before, nodes = os.environ.get("ROS_DOMAIN_ID"), []
    for domain in domains:
        os.environ["ROS_DOMAIN_ID"] = str(domain)
        nodes.append(RosNode())
    os.environ.pop("ROS_DOMAIN_ID")
    if before is not None:
        os.environ["ROS_DOMAIN_ID"] = before
    source, target = nodes
    topics = [topic for d in request.robot.drivers.values() for topic in d.regions.values()]
    pairs = [
        (source.reader(topic, msg.CameraRegions), target.writer(topic, msg.CameraRegions))
        for topic in topics
    ]
    ended = threading.Event()

    def forward() -> None:
        while not ended.wait(0.002):
            for reader, writer in pairs:
                for message in reader.take(8):
                    if message.sample_info.valid_data:
                        writer.write(message)

    thread = threading.Thread(target=forward, daemon=True)
    with contextlib.ExitStack() as within:
        for node in nodes:
            within.enter_context(closing(node))
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()
            pairs.clear()


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each episode, in process and on a served robot."""
    request = shipped_program(condition.program)
    node = condition.name.partition(", ")[2]
    domain = _FIRST_DOMAIN + 2 * (os.getpid() % _PAIRS)
    for part in _consecutive(seeds):
        own = _run(request, body.backend, body.cameras, part)
        left = part
        # A held robot ends its command; the next seed has another robot.
        while left:
            with _served(request, body, domain, node) as driven:
                served = _run(request, "ros2", body.cameras, left, driven)
            for seed, ended in sorted(served.items()):
                inside = seed in own and own[seed].succeeded
                outcomes = {
                    "rewarded": ended.succeeded,
                    "held": ended.held,
                    "as in process": ended.succeeded == inside and not ended.held,
                    "rewarded in process only": inside and not ended.succeeded,
                }
                yield EpisodeVerdict(seed, outcomes, ended.seconds, ended.ending)
            left = range(max(served) + 1, part.stop)


def _consecutive(seeds: Sequence[int]) -> Iterator[range]:
    """Yield ranges of consecutive seeds."""
    begun = 0
    for end in range(1, len(seeds) + 1):
        if end == len(seeds) or seeds[end] != seeds[end - 1] + 1:
            yield range(seeds[begun], seeds[end - 1] + 1)
            begun = end


JUDGE = Judge(
    "served",
    "success on a served robot, in real time by ROS 2, beside the same seeds in process",
    tuple(
        JudgedCondition(
            f"{program}, {node}",
            program,
            {
                "rewarded": ANY,
                "held": NONE,
                "as in process": _MOSTLY,
                "rewarded in process only": ANY,
            },
        )
        for node in (_CYCLONE, _FAST)
        for program in _PROGRAMS
    ),
    _measure,
    BodyChoice("mujoco", "ideal"),
    is_real_time=True,
)
