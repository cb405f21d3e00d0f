"""``cb drive``: drivers of real robots."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.extend.backend import read_robot
from cbdsl.extend.command import (
    Cameras,
    CommandGroup,
    Interface,
    Rate,
    TerminalPerson,
    commands_of,
    needing_simulation,
    print_json,
    print_table,
)

if TYPE_CHECKING:
    from cbdsl.extend.backend import RobotDocument
    from cbdsl.extend.driver import Driver, Endpoint, UrdfModel
    from cbdsl_drive.backend import DrivenBackend


drive = CommandGroup(
    partial(commands_of, "drive"), "Serve, examine and guard the drivers of a robot."
)

Robot = Annotated[str, typer.Argument(help="Robot: file or name.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON.")]


@drive.command("doctor")
def doctor(
    robot: Robot,
    *,
    seconds: Annotated[
        float, typer.Option("--seconds", min=0.1, max=3600, help="Time to listen, s.")
    ] = 3.0,
    cameras: Cameras = None,
    rate: Rate = None,
    interface: Interface = None,
    as_json: Json = False,
) -> None:
    """List topics, joints and stopping times of a robot, and all reasons not to move it.

    No command is sent. Exit 0 if a program can begin, 1 with such reasons, 2 if a driver cannot be
    opened.
    """
    document, urdf = read_robot(robot)
    from cbdsl.extend.backend import read_urdf, with_control_rate
    from cbdsl.extend.driver import stopping_lines

    document = with_control_rate(document, rate)
    with needing_simulation():
        from cbdsl_drive.backend import DrivenBackend

        driven = DrivenBackend(document, urdf, cameras=cameras)
    driven.attend(TerminalPerson(yes=False), interface)
    try:
        endpoints = driven.examine(seconds)
        obstacles = driven.obstacles()
        joints = _joint_rows(driven)
    finally:
        driven.close()
    rows = [_endpoint_row(endpoint) for endpoint in endpoints]
    model = read_urdf(urdf)
    stopping = _stopping_rows(document, model)
    if as_json:
        tables = {"topics": rows, "joints": joints, "stopping": stopping}
        print_json({**tables, "findings": obstacles})
    else:
        print_table("Topics", rows)
        print_table("Joints", joints)
        print_table("Stopping time", stopping)
        for line in stopping_lines(document, model, slow=True):
            print(f"warning: {line}")
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


def _stopping_rows(document: RobotDocument, model: UrdfModel) -> list[dict[str, object]]:
    """Return the longest times until each driver's joints stand as rows of a table."""
    from cbdsl.extend.driver import stopping_times

    return [
        {
            "driver": name,
            "after its program ends": f"{1e3 * time.death:.0f} ms",
            "after a fault": f"{1e3 * time.fault:.0f} ms",
            "after a silent button": _silence(document.drivers[name]),
        }
        for name, time in stopping_times(document, model).items()
    ]


def _silence(driver: Driver) -> str:
    """Return the time until a dead or hung emergency stop is noticed."""
    if driver.stop is None:
        return "no emergency stop"
    if driver.stop_deadline is None:
        return "unnoticed for up to 20 s"
    return f"noticed in {1e3 * driver.stop_deadline:.0f} ms"


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
