"""``cb drive serve`` and ``cb drive watchdog``: robots behind topics of ROS 2."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cbdsl.extend.backend import read_robot
from cbdsl.extend.command import (
    BackendName,
    Cameras,
    Interface,
    Rate,
    needing_simulation,
    stop_requests,
)

Robot = Annotated[str, typer.Argument(help="Robot: file or name.")]
Seconds = Annotated[
    float | None, typer.Option("--seconds", min=0, help="Duration, s [until Ctrl-C].")
]
Stage = Annotated[
    str | None,
    typer.Option("--stage", help="Stage of all episodes: file or name [each program's]."),
]
Context = Annotated[
    str | None, typer.Option("--context", help="Context of the stage [drawn by share].")
]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Seed until a program requests a stage.")]
FaultOption = Annotated[
    list[str],
    typer.Option(
        "--fault",
        help="Fault to inject, KIND@SECONDS; kinds: kill, suspend, stall, loss, clock, nan, swap, "
        "missing, double, frozen, effort. May be repeated.",
    ),
]
Trace = Annotated[
    Path | None,
    typer.Option("--trace", help="NPZ file for times, positions, velocities and references."),
]


def serve(
    robot: Robot,
    *,
    backend: BackendName,
    stage: Stage = None,
    context: Context = None,
    seed: Seed = 0,
    cameras: Cameras = None,
    rate: Rate = None,
    fault: FaultOption = [],  # noqa: B006 (typer)
    trace: Trace = None,
    seconds: Seconds = None,
    interface: Interface = None,
) -> None:
    """Serve a simulated robot behind the topics of its drivers, in real time.

    Commands are followed as by a joint trajectory controller, which holds still at the end of a
    trajectory.
    """
    from cbdsl.extend.command import told_of_compilation
    from cbdsl_ros2.serve import serve_robot

    with needing_simulation(), told_of_compilation(), stop_requests() as stopped:
        serve_robot(
            robot,
            backend=backend,
            stage=stage,
            context=context,
            seed=seed,
            cameras=cameras,
            rate=rate,
            faults=fault,
            trace=trace,
            seconds=seconds,
            interface=interface,
            report=lambda line: print(line, flush=True),
            stopped=stopped,
        )


def watchdog(robot: Robot, *, interface: Interface = None) -> None:
    """Guard forward controllers without a time-out: repeat references, hold, and stop.

    Programs send references to TOPIC/guarded, and the watchdog forwards them to TOPIC. Start it on
    the robot's computer, so that it outlives the program. Exit 3 after a hold, which ends only by a
    new start.
    """
    document, urdf = read_robot(robot)
    with needing_simulation(), stop_requests() as stopped:
        from cbdsl_ros2.guard import Guard

        guard = Guard(document, urdf, interface)
        try:
            for read, written in guard.topics:
                print(f"guarding {written}; references at {read}", flush=True)
            held = guard.watch(lambda line: print(line, flush=True), stopped)
        finally:
            guard.close()
    if held:
        raise typer.Exit(3)
