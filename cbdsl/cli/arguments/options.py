"""Options and arguments shared by several commands."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cbdsl.backends.engines import default_engine
from cbdsl.cli.arguments.completion import names_of

Above = Annotated[
    float,
    typer.Option(
        "--above",
        min=0,
        max=1,
        help="Omit transitions with a relative frequency up to this one, 0 to 1.",
    ),
]
BackendName = Annotated[
    str,
    typer.Option(
        "--backend",
        default_factory=default_engine,
        show_default=False,
        help="Backend: bullet or mujoco (physics), kinematic (no physics), ros2 (a real robot); cb"
        " show backends lists all [the first installed].",
    ),
]
BodyNumber = Annotated[
    int | None,
    typer.Option(
        "--body", min=0, help="Number of the simulated body, which determines its camera errors."
    ),
]
Cameras = Annotated[
    str | None,
    typer.Option("--cameras", help="Cameras: rendered or ideal [the backend's default]."),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of tables.")]
Open = Annotated[bool, typer.Option("--open/--no-open", help="Show the page in the browser.")]
Paths = Annotated[
    list[str], typer.Argument(help="Documents: files, names, folders, or - for the standard input.")
]
Policy = Annotated[
    str | None,
    typer.Option(
        "--policy", help="Policy: file or name [the program's].", autocompletion=names_of("policy")
    ),
]
Program = Annotated[
    str, typer.Argument(help="Program: file or name.", autocompletion=names_of("program"))
]
Rate = Annotated[
    float | None,
    typer.Option("--rate", help="Control rate, Hz [the robot document's].", show_default=False),
]
Recording = Annotated[
    Path,
    typer.Argument(
        metavar="FILE|FOLDER", help="Recording of cb run --record, or a folder of recordings."
    ),
]
Resume = Annotated[
    bool, typer.Option("--resume", help="Continue interrupted trials, or extend finished ones.")
]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Seed of all random numbers.")]
Set = Annotated[
    list[str],
    typer.Option("--set", help="Constant of the learner, such as epsilon=0.1; may be repeated."),
]
ShownProgram = Annotated[
    str,
    typer.Argument(
        metavar="NAME", help="Program: file or name.", autocompletion=names_of("program")
    ),
]
With = Annotated[
    list[str],
    typer.Option("--with", help="Parameter of the program, such as arm=left_arm; may be repeated."),
]
Robot = Annotated[
    str | None,
    typer.Option(
        "--robot",
        help="Robot of a program with roles: file or name [the first one that fits].",
        autocompletion=names_of("robot"),
    ),
]
