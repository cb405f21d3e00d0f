"""Options and arguments shared by several commands."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Above = Annotated[
    float,
    typer.Option("--above", min=0, max=1, help="Leave out arcs of this share and less."),
]
BodyNumber = Annotated[
    int | None,
    typer.Option("--body", min=0, help="Number of the body, which keeps its cameras' errors."),
]
Cameras = Annotated[
    str | None,
    typer.Option("--cameras", help="Its cameras: rendered or ideal [the backend's own]."),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of tables.")]
Open = Annotated[
    bool, typer.Option("--open/--no-open", help="Show the page in the browser when it is made.")
]
Paths = Annotated[
    list[str],
    typer.Argument(help="Documents, names of them, folders of them, or - for the standard input."),
]
Policy = Annotated[
    str | None,
    typer.Option("--policy", help="A policy: its file, or its name [the program's own]."),
]
Program = Annotated[str, typer.Argument(help="A program: its file, or its name.")]
Recording = Annotated[
    Path,
    typer.Argument(
        metavar="FILE|FOLDER", help="Recording of cb run --record, or a folder of recordings."
    ),
]
Resume = Annotated[
    bool, typer.Option("--resume", help="Go on where trials were interrupted, or make them longer.")
]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Seed of all chance.")]
Set = Annotated[
    list[str],
    typer.Option("--set", help="A constant of the learner, as epsilon=0.1; may be repeated."),
]
ShownProgram = Annotated[str, typer.Argument(metavar="NAME", help="Name or file of a program.")]
With = Annotated[
    list[str],
    typer.Option("--with", help="A parameter of the program, as arm=left_arm; may be repeated."),
]
