"""``cb schema``: JSON Schemas of documents, for editors and for CI."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.cli.output.terminal import print_line, warn_of_faults
from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.reason import reason
from cbdsl.documents.json_schema import json_schema, json_text, schema_file
from cbdsl.documents.kinds import KINDS, models
from cbdsl.storage.atomic_file import write_text

if TYPE_CHECKING:
    from cbdsl.documents.document import Document

Kind = Annotated[str | None, typer.Argument(help="Kind of document, such as program [all].")]
Write = Annotated[
    Path | None,
    typer.Option("--write", help="Folder to write <kind>.schema.json to, instead of printing."),
]


def schema(kind: Kind = None, write: Write = None) -> None:
    """Print the JSON Schema of a kind of document, or write it for editors and CI.

    Editors with YAML support complete and check a document whose first line is
    "# yaml-language-server: $schema=" with the path of its schema; cb new writes that line.

    Without a kind, print a JSON object with the schemas of all kinds.
    """
    kinds = _kinds(kind)
    if write is not None:
        _write(kinds, write)
    elif kind is not None:
        print(json_text(json_schema(kinds[kind])), end="")
    else:
        schemas = {name: json_schema(model) for name, model in kinds.items()}
        print(json_text(schemas), end="")


def _kinds(kind: str | None) -> dict[str, type[Document]]:
    """Return the model of a named kind, or of all kinds, by name."""
    if kind is not None:
        return {kind: KINDS.get(kind).model}
    warn_of_faults(KINDS)
    return models()


def _write(kinds: dict[str, type[Document]], folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, model in kinds.items():
            file = folder / schema_file(name)
            write_text(json_text(json_schema(model)), file)
            print_line(f"wrote {file}")
    except OSError as error:
        raise UsageError(f"--write {folder}: {reason(error)}") from error
