"""``cb validate``: all diagnostics of documents, without simulator and network."""

from __future__ import annotations

from typing import Annotated

import typer

from cbdsl.cli.arguments.assignments import read_assignments
from cbdsl.cli.arguments.options import Paths, Robot
from cbdsl.cli.validation import STANDARD_INPUT_NAME, check_paths

# Texts instead of paths: typer's conversion of paths costs a tenth of the whole command.
With = Annotated[
    list[str],
    typer.Option(
        "--with", help="Parameter of the programs, such as arm=left_arm; may be repeated."
    ),
]
Form = Annotated[str, typer.Option("--format", help="Output format: text, json, github or sarif.")]
Json = Annotated[bool, typer.Option("--json", help="Short for --format json.")]
Strict = Annotated[bool, typer.Option("--strict", help="Exit with 1 for warnings as well.")]
Fix = Annotated[
    bool,
    typer.Option(
        "--fix", help="Replace misspelled names by the nearest ones in the files, then check."
    ),
]
StdinName = Annotated[
    str, typer.Option("--stdin-name", help="File name of the standard input in diagnostics.")
]


def validate(
    paths: Paths,
    with_: With = [],  # noqa: B006 (typer)
    robot: Robot = None,
    form: Form = "text",
    as_json: Json = False,
    strict: Strict = False,
    fix: Fix = False,
    stdin_name: StdinName = STANDARD_INPUT_NAME,
) -> None:
    """Check documents without running them.

    Exit 0 without errors, 1 with errors, 2 for wrong arguments or an internal error.
    """
    values = read_assignments(with_, robot=robot)
    if fix:
        from cbdsl.cli.fix import fix_paths

        fix_paths(paths, values)
    raise typer.Exit(check_paths(paths, values, "json" if as_json else form, strict, stdin_name))
