"""``cb explain``: what a code of a diagnostic means."""

from __future__ import annotations

from typing import Annotated

import typer

Code = Annotated[str, typer.Argument(help="Code of a diagnostic, such as CB504.")]


def explain(code: Code) -> None:
    """Say what a diagnostic means, why it is a fault, and what has it."""
    import textwrap

    from cbdsl.errors.catalogue import CATALOGUE
    from cbdsl.errors.errors import UsageError
    from cbdsl.errors.nearest import nearest_name

    entry = CATALOGUE.get(code.upper())
    if entry is None:
        nearest = nearest_name(code.upper(), CATALOGUE)
        hint = f"; did you mean {nearest}?" if nearest else ""
        raise UsageError(f"there is no diagnostic {code}{hint}")
    print(f"{entry.code}: {entry.title}\n")
    print(textwrap.fill(entry.explanation, 88))
    if isinstance(entry.example, str):
        print(f"\nFor example, in {entry.path}:\n")
        print(textwrap.indent(entry.example, "    ").rstrip())
