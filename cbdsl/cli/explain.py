"""``cb explain``: meaning of the code of a diagnostic."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.cli.arguments.completion import codes
from cbdsl.cli.output.terminal import warn_of_faults
from cbdsl.diagnostics.entry_text import explanation, page
from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.nearest import nearest_name
from cbdsl.documents.kinds import KINDS, entries, entry_of

if TYPE_CHECKING:
    from cbdsl.diagnostics.entry import Entry

Code = Annotated[
    str | None, typer.Argument(help="Code of a diagnostic, such as CB504.", autocompletion=codes)
]
All = Annotated[bool, typer.Option("--all", help="Explain all codes.")]
Markdown = Annotated[bool, typer.Option("--markdown", help="Print a page of documentation.")]


def explain(code: Code = None, every: All = False, markdown: Markdown = False) -> None:
    """Print the meaning of a diagnostic, its reason, and a wrong and a correct example."""
    entries = _entries(code, every)
    print(page(entries) if markdown else "\n\n".join(explanation(entry) for entry in entries))


def _entries(code: str | None, every: bool) -> list[Entry]:
    if every != (code is None):
        raise UsageError("explain wants a code such as CB504, or --all")
    if code is None:
        warn_of_faults(KINDS)
        return sorted(entries().values(), key=lambda entry: entry.code)
    entry = entry_of(code.upper())
    if entry is None:
        raise UsageError(
            f"unknown code '{code}'{_suggestion(code, entries())} (cb explain --all has all)"
        )
    return [entry]


def _suggestion(code: str, known: Iterable[str]) -> str:
    """Return the question for the nearest code, without regard to the common prefix."""
    # With the common prefix, each code would be similar to each other.
    numbers = {each.removeprefix("CB"): each for each in known}
    nearest = nearest_name(code.upper().removeprefix("CB"), numbers)
    return f"; did you mean '{numbers[nearest]}'?" if nearest else ""
