"""``cb export``: programs and recordings in formats of other tools."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from cbdsl.api.requests.run_request import read_program
from cbdsl.cli.arguments.assignments import read_assignments
from cbdsl.cli.arguments.options import Policy, Program, Recording, With
from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.reason import reason
from cbdsl.program.behavior_tree import behavior_tree

export = typer.Typer(
    help="Write programs and recordings in formats of other tools.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

#: Message schemas of MCAP files.
SCHEMAS = ("foxglove", "ros2")

Out = Annotated[
    Path | None, typer.Option("--out", help="File to write [beside the recording, .mcap].")
]
Schemas = Annotated[
    str, typer.Option("--schemas", help="Message schemas: foxglove (JSON) or ros2 (CDR).")
]
Folder = Annotated[
    Path | None, typer.Option("--out", help="Folder to write [lerobot, beside the recordings].")
]
Fps = Annotated[
    int | None, typer.Option("--fps", min=1, help="Frames per second [the rate of the images].")
]
Task = Annotated[
    str | None, typer.Option("--task", help="Sentence that names the task [the program's name].")
]
Videos = Annotated[
    bool,
    typer.Option("--videos", help="Store images as MP4 videos, which are smaller and lossy [PNG]."),
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace an existing dataset.")]


@export.command("tree")
def export_tree(program: Program, policy: Policy = None, with_: With = []) -> None:  # noqa: B006
    """Print a program's policy as a behavior tree, XML of BehaviorTree.CPP 4.

    Each use of a program is a separate tree, with the values of its parameters. The model at the
    end names the leaves. Exit 2 if the next action depends on more than the state.
    """
    print(behavior_tree(read_program(program, policy, read_assignments(with_))), end="")


@export.command("mcap")
def export_mcap(what: Recording, out: Out = None, schemas: Schemas = "foxglove") -> None:
    """Write recorded episodes as MCAP, for Foxglove, ROS 2 and other tools.

    The file has joint states, transforms, objects, images, potentials, predicates and transitions,
    by simulated time. With --schemas ros2, messages are those of ROS 2 (sensor_msgs, geometry_msgs,
    tf2_msgs and others), with wrenches and camera intrinsics. Requires the extra mcap.
    """
    if schemas not in SCHEMAS:
        raise UsageError.unknown("kind of schemas", schemas, SCHEMAS)
    # Imports are here, because packages of an extra may be missing.
    with needed("MCAP", "mcap"):
        from cbdsl_mcap.mcap_file import write_mcap
        from cbdsl.reporting.recorded import find_recordings, read_recording
        from cbdsl_ros2.export.file import write_ros2_mcap
    recordings = find_recordings(what)
    if out is not None and len(recordings) > 1:
        raise UsageError(
            f"--out {out}: {what} holds {len(recordings)} recordings; name one of them"
        )
    write = write_ros2_mcap if schemas == "ros2" else write_mcap
    for file in recordings:
        target = out or file.with_suffix(".mcap")
        # Outside of the context that names the target: errors of reading name the recording.
        recorded = read_recording(file)
        with named_problems(target):
            messages = write(recorded, target)
        print(f"{target}: {messages} messages, {target.stat().st_size / 1e6:.1f} MB")


@export.command("lerobot")
def export_lerobot(
    what: Recording,
    out: Folder = None,
    fps: Fps = None,
    task: Task = None,
    videos: Videos = False,
    overwrite: Overwrite = False,
) -> None:
    """Write recorded episodes as a dataset of LeRobot, format v3.0, to train policies.

    Each frame has joint positions, velocities, load cells and images, the joint references as the
    action, rewards, and the state and action of the program. Requires the extra lerobot.
    """
    with needed("A LeRobot dataset", "lerobot"):
        from cbdsl_lerobot.dataset import write_dataset
        from cbdsl.reporting.recorded import find_recordings, read_recording
    recordings = find_recordings(what)
    target = out or recordings[0].parent / "lerobot"
    with named_problems(target):
        episodes, frames = write_dataset(
            map(read_recording, recordings),
            target,
            rate=fps,
            task=task,
            videos=videos,
            overwrite=overwrite,
        )
    print(f"{target}: {frames} frames of {episodes} episode{'s' if episodes > 1 else ''}")


@contextmanager
def needed(product: str, extra: str) -> Iterator[None]:
    """Name the extra to install if a module is missing.

    Raises:
        UsageError: A module is not installed.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        raise UsageError(
            f"{product} needs {error.name}, which is not installed: pip install 'cbdsl[{extra}]'"
        ) from error


@contextmanager
def named_problems(target: Path) -> Iterator[None]:
    """Name the file that cannot be written.

    Raises:
        UsageError: The file cannot be written.
    """
    try:
        yield
    except OSError as error:
        raise UsageError(f"{target}: {reason(error)}") from error
