"""``cb show knowledge``: learned documents, and their inputs that have changed."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from cbdsl.cli.output.terminal import print_json, print_table
from cbdsl.cli.show.formats import PLAIN, Format, Json, PlainFormat, read_format

Check = Annotated[bool, typer.Option("--check", help="Exit with 1 if a document is stale.")]


def show_knowledge(
    *, check: Check = False, format_: PlainFormat = "text", as_json: Json = False
) -> None:
    """Show learned documents of this folder or of the package, and which are stale.

    A document is stale if its program, robot, stage or a policy has changed since it was learned.
    Shared documents that changed a program are listed with it.
    """
    form = read_format(format_, as_json, PLAIN)
    rows = _rows()
    if form is Format.JSON:
        print_json(rows)
    else:
        print_table(
            "Learned documents",
            [
                {
                    "kind": row["kind"],
                    "name": row["name"],
                    "changed since": ", ".join(row["changed"]) or "nothing",
                }
                for row in rows
            ],
        )
    if check and any(row["changed"] for row in rows):
        raise typer.Exit(1)


def _rows() -> list[dict[str, Any]]:
    """Return one row for each learned document: its kind, name, file, command and changes."""
    from cbdsl.checking.knowledge.staleness import LEARNED, changed_inputs
    from cbdsl.documents.kinds import kind_name
    from cbdsl.yaml_text.library import Library

    library = Library()
    files = [(kind, library.locate(kind, name)) for kind in LEARNED for name in library.names(kind)]
    return [
        {
            "kind": kind_name(kind),
            "name": loaded.document.name,
            "file": str(file),
            "changed": list(changed_inputs(loaded.document, file, library)),
            "command": getattr(getattr(loaded.document, "provenance", None), "command", ""),
        }
        for kind, file in files
        for loaded in [library.read(file, kind)]
    ]
