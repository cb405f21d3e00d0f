"""Terminal output of the commands."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cbdsl.cli.process.legible_output import raw
from cbdsl.diagnostics.diagnostic import Diagnostic
from cbdsl.diagnostics.legible_text import legible, one_line
from cbdsl.diagnostics.text_format import text
from cbdsl.diagnostics.validation_report import ValidationReport

if TYPE_CHECKING:
    from rich.console import Console

    from cbdsl.types.registry import Registry

# Wide enough for every table in output that is not folded.
_WIDTH_OF_PIPES = 200


def console() -> Console:
    """Return a rich console on the standard output."""
    from rich.console import Console

    width = None if sys.stdout.isatty() else _WIDTH_OF_PIPES
    return Console(width=width, highlight=False, file=raw(sys.stdout))


def print_diagnostics(diagnostics: Iterable[Diagnostic]) -> None:
    """Print diagnostics with snippets, and how many there are."""
    print(text(ValidationReport(tuple(diagnostics), documents=0, left_out=0, text_of=_text)))


def print_json(data: object) -> None:
    """Print data for scripts."""
    import json

    print(json.dumps(data, indent=2, ensure_ascii=False))


def print_table(title: str, rows: Iterable[Mapping[str, object]]) -> None:
    """Print rows under the headings of the first."""
    from rich import box
    from rich.table import Table

    cells = list(rows)
    table = Table(title=legible(title), title_justify="left", box=box.SIMPLE_HEAD)
    for heading in cells[0] if cells else ():
        table.add_column(heading, overflow="fold")  # a name cut short names nothing
    for row in cells:
        table.add_row(*(_cell(value) for value in row.values()))
    console().print(table, markup=False)


def _cell(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else ""
    return legible(str(value))


def print_line(text: str) -> None:
    """Print a text with names of files, whose line breaks are written as escapes."""
    print(one_line(text), flush=True)


def print_problem(message: str) -> None:
    """Print the reason why a command failed."""
    print(f"cb: {one_line(message)}", file=sys.stderr)


def warn_of_faults(*registries: Registry[Any]) -> None:
    """Name the faulty plug-ins of registries, with their packages, on the standard error."""
    for registry in registries:
        for fault in registry.faults():
            print_problem(f"warning: {fault}")


@cache
def _text(file: str) -> str | None:
    """Return a file's text for snippets, or ``None`` if it has none."""
    from cbdsl.diagnostics.errors import DiagnosticsError
    from cbdsl.yaml_text.reader import read_text

    try:
        return read_text(Path(file))
    except DiagnosticsError:
        return None
