"""``cb mcp``: server for clients of the Model Context Protocol."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

import cbdsl
from cbdsl_mcp.server import make_server

Folder = Annotated[
    Path,
    typer.Option(
        "--folder", exists=True, file_okay=False, help="Folder of documents and written files."
    ),
]
AllowHardware = Annotated[
    str | None,
    typer.Option(
        "--allow-hardware",
        metavar="ROBOT",
        help="Robot whose real body may move; each run asks a person at the client.",
    ),
]


def mcp(folder: Folder = Path(), allow_hardware: AllowHardware = None) -> None:
    """Serve tools of cb to a client of the Model Context Protocol, by standard input and output.

    Tools list, show, validate, explain and fix documents, and start runs, explanations,
    comparisons, learning and exploration as jobs. They read and write files of one folder, and
    run simulators only, unless --allow-hardware names a robot.
    """
    if sys.stdin is None or sys.stdout is None:
        raise cbdsl.UsageError("a client has to be at the standard input and output")
    make_server(folder.resolve(), allow_hardware).run("stdio")
