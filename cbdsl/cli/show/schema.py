"""``cb show schema``: the trees of a schema, as text, as data, or as a picture."""

from __future__ import annotations

from difflib import unified_diff
from typing import Annotated

import typer

from cbdsl.cli.output.terminal import print_json
from cbdsl.cli.show.formats import Format, Json, drawing, read_format
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.schema import SchemaDocument
from cbdsl.reporting.drawing.schema_graph import schema_graph
from cbdsl.reporting.text.schema_text import schema_text
from cbdsl.yaml_text.library import Library

Schema = Annotated[str, typer.Argument(metavar="FILE|NAME", help="Schema: file or name.")]
Against = Annotated[
    str | None,
    typer.Option("--against", metavar="FILE|NAME", help="Another schema to compare with."),
]
FormatOption = Annotated[
    str,
    typer.Option(
        "--format", help="Output format: text or json; dot, mermaid or svg for the trees."
    ),
]


def show_schema(
    name: Schema,
    against: Against = None,
    format_: FormatOption = "text",
    as_json: Json = False,
) -> None:
    """Show the allocation of resources by a schema, and its contexts without expected reward.

    --against prints the lines that differ from another schema: - for its lines, + for those of the
    first.
    """
    form = read_format(format_, as_json)
    if against is not None and form is not Format.TEXT:
        raise UsageError("--against compares the texts of two schemas, whatever --format")
    schema = _read(name)
    if against is not None:
        print(_difference(_read(against), schema), end="")
    elif form is Format.JSON:
        print_json(schema.model_dump(mode="json", by_alias=True, exclude_none=True))
    elif form is Format.TEXT:
        print(schema_text(schema), end="")
    else:
        print(drawing(schema_graph(schema), form), end="")


def _read(name: str) -> SchemaDocument:
    library = Library()
    return library.read(library.locate(SchemaDocument, name), SchemaDocument).document


def _difference(other: SchemaDocument, schema: SchemaDocument) -> str:
    """Return the differing lines of two schemas' texts, with all lines around them."""
    before, after = (schema_text(each).splitlines() for each in (other, schema))
    # The first three lines are the names of two files and their line numbers, which texts do not
    # have.
    lines = list(unified_diff(before, after, lineterm="", n=len(before) + len(after)))[3:]
    return "\n".join(lines or ["no difference"]) + "\n"
