"""``cb validate``: all findings in documents, without simulator and network."""

from __future__ import annotations

from typing import Annotated

import typer

# Texts instead of paths: typer's conversion of paths costs a tenth of the whole command.
Paths = Annotated[list[str], typer.Argument(help="Documents, or folders of documents.")]
With = Annotated[
    list[str],
    typer.Option("--with", help="A parameter of a program, as arm=left_arm; may be repeated."),
]
Json = Annotated[bool, typer.Option("--json", help="Print the findings as JSON.")]


def validate(paths: Paths, with_: With = [], as_json: Json = False) -> None:  # noqa: B006 (typer)
    """Check documents without running them.

    Exit 0 without errors, 1 with errors, 2 for a wrong call.
    """
    from cbdsl.cli.assignments import read_assignments
    from cbdsl.cli.findings import check_paths

    raise typer.Exit(check_paths(paths, read_assignments(with_), as_json))
