"""Success of programs on a served robot, beside the same seeds in process.

Each episode has three processes: this one, a simulated robot in real time, and the program that
drives it by ROS 2. They are forked after all imports, so that an episode starts in seconds. The
robot's own sensors decide on the reward. Rates come with exact (Clopper-Pearson) 95 % intervals.

    python benchmarks/served.py --count 40 [--first 500] [--programs reachtouch] [--cameras ideal]
        [--where served] [--domain 50] [--out build/served.jsonl]
    python benchmarks/served.py --summary build/served.jsonl
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

from cbdsl.api.run_request import RunRequest, read_request
from cbdsl.numeric.proportion import exact_interval
from cbdsl.runtime.episode_observer import EpisodeListeners

PROGRAMS = ("reachtouch", "visualinspect", "pick_and_place")
CAMERAS = ("ideal", "rendered")
PLACES = ("process", "served")


class Episode(NamedTuple):
    """Outcome of an episode; times and shares of 0 if it could not begin.

    Attributes:
        program, cameras, where, seed: Names of the conditions, and the seed.
        rewarded: True if the program earned its reward.
        ending: Last sentence.
        seconds: Time of the robot, s.
        share: Processor time of the program per time, from the first tick on.
        factor: Real-time factor of the served robot.
    """

    program: str
    cameras: str
    where: str
    seed: int
    rewarded: bool
    ending: str
    seconds: float
    share: float
    factor: float


def forked(work: Callable[[Callable[[str], None]], None]) -> tuple[int, Iterator[str]]:
    """Start a function in a child process, with a function that sends lines to this one."""
    source, sink = os.pipe()
    child = os.fork()
    if child:
        os.close(sink)
        return child, iter(os.fdopen(source))
    os.close(source)
    try:
        work(lambda line: void(os.write(sink, f"{line}\n".encode())))
    except BaseException:
        traceback.print_exc()
    finally:
        # The child must not run the exit handlers that it shares with its parent.
        os._exit(0)


def void(_: object) -> None:
    """Return nothing."""


def end(child: int) -> None:
    """Ask a child to end, and wait for it."""
    with suppress(ProcessLookupError):
        os.kill(child, signal.SIGTERM)
    with suppress(ChildProcessError):
        os.waitpid(child, 0)


@contextmanager
def served(request: RunRequest, cameras: str, seed: int) -> Iterator[Iterator[str]]:
    """Serve the robot on the program's stage; yield its lines of output after the first."""
    from cbdsl.api.serve import serve_robot

    def serve(report: Callable[[str], None]) -> None:
        stopped: list[int] = []
        signal.signal(signal.SIGTERM, lambda number, _: stopped.append(number))
        serve_robot(
            request.robot.name, backend="mujoco", stage=request.stage.name, seed=seed,
            cameras=cameras, report=report, stopped=lambda: bool(stopped),
        )  # fmt: skip

    child, lines = forked(serve)
    try:
        next(lines)
        yield lines
    finally:
        end(child)


def run(request: RunRequest, cameras: str, where: str, seed: int) -> dict[str, Any]:
    """Run a program on an own or a served robot; return the fields that it measures."""
    from cbdsl.backends.backend import embody
    from cbdsl.backends.drivers.backend import DrivenBackend
    from cbdsl.backends.drivers.person import Consent
    from cbdsl.kinematics.kinematics import Kinematics
    from cbdsl.runtime.episode import Runner
    from cbdsl.runtime.episode_result import EpisodeResult
    from cbdsl.runtime.tick import Tick

    backend: Any
    if where == "served":
        driven = backend = DrivenBackend(request.robot, request.urdf, cameras=cameras)
        driven.attend(Consent())
    else:
        backend = embody("mujoco", request.robot, request.urdf, cameras=cameras)
    begun: list[tuple[float, float]] = []
    results: list[EpisodeResult] = []

    def note(_: Tick) -> None:
        if not begun:
            begun.append((time.process_time(), time.monotonic()))

    with closing(backend):
        runner = Runner(
            request.robot, Kinematics(request.robot, request.urdf), request.program, backend
        )
        try:
            runner.run(
                request.stage, seed, observer=EpisodeListeners(on_tick=note, on_end=results.append)
            )
        except Exception as error:
            return _fields(begun, results, str(error), rewarded=False)
    return _fields(begun, results, results[0].ending, rewarded=results[0].rewarded)


def _fields(
    begun: list[tuple[float, float]], results: list[Any], ending: str, *, rewarded: bool
) -> dict[str, Any]:
    processor, wall = begun[0] if begun else (time.process_time(), time.monotonic())
    share = (time.process_time() - processor) / max(time.monotonic() - wall, 1e-3)
    seconds = results[0].sim_seconds if results else 0.0
    return {
        "rewarded": rewarded, "ending": ending, "seconds": seconds, "share": round(share, 3),
    }  # fmt: skip


def episode(request: RunRequest, cameras: str, where: str, seed: int) -> Episode:
    """Run one episode."""
    conditions: dict[str, Any] = {
        "program": request.program.name,
        "cameras": cameras,
        "where": where,
        "seed": seed,
    }

    def work(report: Callable[[str], None]) -> None:
        report(json.dumps(run(request, cameras, where, seed)))

    def outcome() -> dict[str, Any]:
        child, lines = forked(work)
        fields: dict[str, Any] = json.loads(next(lines))
        end(child)
        return fields

    if where == "process":
        return Episode(**conditions, **outcome(), factor=0.0)
    with served(request, cameras, seed) as lines:
        fields = outcome()
    # The pipe keeps the lines of the server after its end.
    factor = [float(line.rsplit(" ", 1)[1]) for line in lines if "real-time factor" in line][-1]
    return Episode(**conditions, **fields, factor=factor)


def warm(request: RunRequest) -> None:
    """Import modules and load machine code before the first fork."""
    from cbdsl.api.rehearsal import rehearse
    from cbdsl.backends.ros2 import topic_server as server  # noqa: F401

    rehearse(request)


def summary(lines: list[str]) -> str:
    """Return a table of outcomes by program and cameras."""
    outcomes = [Episode(**json.loads(line)) for line in lines]
    rows = [
        "| program | cameras | in process | served | load of a core | least real-time factor |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for program in PROGRAMS:
        for cameras in CAMERAS:
            own = [o for o in outcomes if (o.program, o.cameras) == (program, cameras)]
            process, driven = ([o for o in own if o.where == where] for where in PLACES)
            if not driven:
                continue
            load = sum(o.share for o in driven) / len(driven)
            least = min(o.factor for o in driven)
            rows.append(
                f"| `{program}` | {cameras} | {_rate(process)} | {_rate(driven)} | "
                f"{100 * load:.0f} % | {least:.2f} |"
            )
    return "\n".join(rows)


def _rate(outcomes: list[Episode]) -> str:
    """Return the number of rewarded episodes, with its interval."""
    if not outcomes:
        return "-"
    hits = sum(outcome.rewarded for outcome in outcomes)
    low, high = exact_interval(hits, len(outcomes))
    return f"{hits} of {len(outcomes)} ({100 * low:.1f} to {100 * high:.1f} %)"


def main() -> None:
    """Run episodes, or print a table of earlier ones."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--first", type=int, default=500)
    parser.add_argument("--programs", nargs="*", default=PROGRAMS)
    parser.add_argument("--cameras", nargs="*", default=CAMERAS)
    parser.add_argument("--where", nargs="*", default=PLACES)
    parser.add_argument("--domain", type=int, default=50)
    parser.add_argument("--out", type=Path, default=Path("build/served.jsonl"))
    parser.add_argument("--summary", nargs="*", type=Path)
    options = parser.parse_args()
    if options.summary:
        lines = [line for path in options.summary for line in path.read_text().splitlines()]
        sys.stdout.write(summary(lines) + "\n")
        return
    os.environ["ROS_DOMAIN_ID"] = str(options.domain)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    requests = [read_request(program, None, None, {}) for program in options.programs]
    for request in requests:
        warm(request)
    for seed in range(options.first, options.first + options.count):
        for request in requests:
            for cameras in options.cameras:
                for where in options.where:
                    line = json.dumps(episode(request, cameras, where, seed)._asdict())
                    with options.out.open("a") as file:
                        file.write(line + "\n")
                    sys.stdout.write(line + "\n")
                    sys.stdout.flush()


if __name__ == "__main__":
    main()
