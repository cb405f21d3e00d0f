"""``cb --version``."""

from __future__ import annotations

from importlib.metadata import version
from typing import Annotated

import typer


def _tell(wanted: bool) -> None:
    if wanted:
        print(f"cbdsl {version('cbdsl')}")
        raise typer.Exit


Version = Annotated[
    bool,
    typer.Option("--version", callback=_tell, is_eager=True, help="Print the version and exit."),
]


def options(show_version: Version = False) -> None:
    """Options of ``cb`` itself; a command's own follow its name."""
