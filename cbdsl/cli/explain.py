"""``cb explain``: what the code of a finding means."""

from __future__ import annotations

from typing import Annotated

import typer

Code = Annotated[str, typer.Argument(help="Code of a finding, such as CB504.")]


def explain(code: Code) -> None:
    """What a finding means, why it is a fault, and an example that has it."""
    import textwrap

    from cbdsl.errors.catalogue import CATALOGUE
    from cbdsl.errors.errors import UsageError
    from cbdsl.errors.nearest import nearest_name

    entry = CATALOGUE.get(code.upper())
    if entry is None:
        nearest = nearest_name(code.upper(), CATALOGUE)
        hint = f"; did you mean {nearest}?" if nearest else ""
        raise UsageError(f"there is no finding {code}{hint}")
    print(f"{entry.code}: {entry.title}\n")
    print(textwrap.fill(entry.explanation, 88))
    if isinstance(entry.example, str):
        print(f"\nFor example, in {entry.path}:\n")
        print(textwrap.indent(entry.example, "    ").rstrip())
