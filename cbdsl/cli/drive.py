"""``cb drive``: real robots, and simulated ones behind the same topics."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.api.reading.robots import read_robot
from cbdsl_ros2.serve import serve_robot
from cbdsl.cli.arguments.options import Cameras, Rate
from cbdsl.cli.episodes.attendance import Interface, TerminalPerson
from cbdsl.cli.episodes.simulation import BackendName, needing_simulation
from cbdsl.cli.output.terminal import print_json, print_table
from cbdsl.cli.process.termination import stop_requests

if TYPE_CHECKING:
    from cbdsl.backends.drivers.backend import DrivenBackend
    from cbdsl.backends.drivers.link import Endpoint


drive = typer.Typer(help="Serve, examine and guard the drivers of a robot.", no_args_is_help=True)

Robot = Annotated[str, typer.Argument(help="Robot: file or name.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON.")]
Seconds = Annotated[
    float | None, typer.Option("--seconds", min=0, help="Duration, s [until Ctrl-C].")
]
Stage = Annotated[
    str | None, typer.Option("--stage", help="Stage to set up: file or name [an empty one].")
]
Context = Annotated[
    str | None, typer.Option("--context", help="Context of the stage [drawn by share].")
]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Seed of the episode.")]
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


@drive.command("serve")
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
    from cbdsl.cli.output.compilation import told_of_compilation

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


@drive.command("doctor")
def doctor(
    robot: Robot,
    *,
    seconds: Annotated[
        float, typer.Option("--seconds", min=0.1, max=3600, help="Time to listen, s.")
    ] = 3.0,
    cameras: Cameras = None,
    interface: Interface = None,
    as_json: Json = False,
) -> None:
    """List the topics, rates, ages and joints of a robot, and all reasons not to move it.

    No command is sent. Exit 0 if a program can begin, 1 with such reasons, 2 if a driver cannot be
    opened.
    """
    document, urdf = read_robot(robot)
    with needing_simulation():
        from cbdsl.backends.drivers.backend import DrivenBackend

        driven = DrivenBackend(document, urdf, cameras=cameras)
    driven.attend(TerminalPerson(yes=False), interface)
    try:
        endpoints = driven.examine(seconds)
        obstacles = driven.obstacles()
        joints = _joint_rows(driven)
    finally:
        driven.close()
    rows = [_endpoint_row(endpoint) for endpoint in endpoints]
    if as_json:
        print_json({"topics": rows, "joints": joints, "findings": obstacles})
    else:
        print_table("Topics", rows)
        print_table("Joints", joints)
        for obstacle in obstacles:
            print(f"finding: {obstacle}")
        print("not ready" if obstacles else "ready")
    if obstacles:
        raise typer.Exit(1)


def _endpoint_row(endpoint: Endpoint) -> dict[str, object]:
    """Return a stream as a row of a table."""
    age = "" if endpoint.age is None else f"{1e3 * endpoint.age:.0f} ms"
    return {
        "driver": endpoint.driver,
        "role": endpoint.role,
        "topic": endpoint.address,
        "type": endpoint.type,
        "peers": endpoint.peers,
        "rate": "" if endpoint.outgoing else f"{endpoint.rate:.1f} Hz",
        "age": age,
    }


def _joint_rows(driven: DrivenBackend) -> list[dict[str, object]]:
    """Return the joints that were heard as rows of a table."""
    joints = driven.supervisor.joints
    # A joint without a message has no position; its initial value would look like a measurement.
    unheard = {name for _, names in joints.unheard() for name in names}
    return [
        {"joint": name, "position": f"{position:.4f}", "velocity": f"{velocity:.4f}"}
        for name, position, velocity in zip(
            joints.names, joints.positions, joints.velocities, strict=True
        )
        if name not in unheard
    ]


@drive.command("watchdog")
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
