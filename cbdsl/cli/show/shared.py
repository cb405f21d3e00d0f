"""``cb show shared``: the controllers and conditions that programs take up by name."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.cli.arguments.completion import names_of
from cbdsl.cli.show.formats import PLAIN, Format, Json, PlainFormat, read_format

if TYPE_CHECKING:
    from cbdsl.documents.shared import SharedDocument

Shared = Annotated[
    str,
    typer.Argument(
        metavar="FILE|NAME",
        help="Shared controllers: file or name.",
        autocompletion=names_of("shared"),
    ),
]


def show_shared(name: Shared, format_: PlainFormat = "text", as_json: Json = False) -> None:
    """Show the controllers and conditions of a shared document by their signatures."""
    from cbdsl.cli.output.terminal import print_json
    from cbdsl.documents.shared import SharedDocument
    from cbdsl.yaml_text.library import Library

    form, library = read_format(format_, as_json, PLAIN), Library()
    loaded = library.read(library.locate(SharedDocument, name), SharedDocument)
    if form is Format.JSON:
        print_json(loaded.document.model_dump(mode="json", exclude_defaults=True))
        return
    document = loaded.document
    print(f"{document.name}: {' '.join(document.description.split())}")
    given = ", ".join(f"{name} = {value}" for name, value in document.parameters.items())
    print(f"  checked on {document.robot}{' with ' if given else ''}{given}")
    for signature, text in _lines(document):
        print(f"\n  {signature}\n    {text}")


def _lines(document: SharedDocument) -> list[tuple[str, str]]:
    """Return each signature with a short description."""
    lines = []
    for signature, part in document.controllers.items():
        if isinstance(part, str):
            lines.append((signature, part))
            continue
        reference = part.get("reference", "")
        value = f"[{', '.join(map(str, reference))}]" if isinstance(reference, list) else reference
        goal = f" to {value}" if value != "" else ""
        text = f"{part.get('potential')} of {part.get('feedback')}{goal}, by {part.get('effector')}"
        lines.append((signature, text))
    return [*lines, *document.conditions.items()]
