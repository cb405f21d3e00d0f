"""``cb export``: programs and recordings in formats of other tools."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cbdsl.cli.options import Policy, Program, Recording

export = typer.Typer(
    help="Write programs and recordings in formats of other tools.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

Out = Annotated[
    Path | None, typer.Option("--out", help="The file to write [beside the recording, .mcap].")
]


@export.command("tree")
def export_tree(program: Program, policy: Policy = None) -> None:
    """Print a program's policy as a behavior tree, XML of BehaviorTree.CPP 4.

    Its leaves are named in the model at the end: two conditions and the action that runs a
    composition. Exit 2 where what is done follows from more than the state.
    """
    from cbdsl.api.load import load
    from cbdsl.program.behavior_tree import behavior_tree

    print(behavior_tree(load(program, policy=policy).program), end="")


@export.command("mcap")
def export_mcap(what: Recording, out: Out = None) -> None:
    """Write recorded episodes as MCAP, which Foxglove and other viewers open.

    Joint states, transforms, things, images, potentials, predicates and transitions, by simulated
    time. Needs the extra mcap.
    """
    from cbdsl.errors.errors import UsageError

    try:
        from cbdsl.reporting.mcap_file import write_mcap
        from cbdsl.reporting.recorded import find_recordings, read_recording
    except ModuleNotFoundError as error:
        raise UsageError(
            f"MCAP needs {error.name}, which is not installed: pip install 'cbdsl[mcap]'"
        ) from error
    recordings = find_recordings(what)
    if out is not None and len(recordings) > 1:
        raise UsageError(
            f"--out {out}: {what} holds {len(recordings)} recordings; name one of them"
        )
    for file in recordings:
        target = out or file.with_suffix(".mcap")
        messages = write_mcap(read_recording(file), target)
        print(f"{target}: {messages} messages, {target.stat().st_size / 1e6:.1f} MB")
