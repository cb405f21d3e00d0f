"""``cb list``: documents that commands find by name."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.cli.output.terminal import print_json, print_table, warn_of_faults
from cbdsl.cli.show.formats import PLAIN, Format, Json, PlainFormat, read_format
from cbdsl.diagnostics.errors import DiagnosticsError, UsageError
from cbdsl.documents.kinds import KINDS, models
from cbdsl.yaml_text.library import Library

if TYPE_CHECKING:
    from cbdsl.documents.document import Document

Kind = Annotated[
    str | None,
    typer.Argument(
        metavar="[KIND]", help="Kind of the documents, such as robots, programs or stages [all]."
    ),
]

# Length of the printed part of a description; the rest is in the document.
_LONGEST = 76


def list(kind: Kind = None, format_: PlainFormat = "text", as_json: Json = False) -> None:
    """List the documents that commands find by name from this folder, with their paths."""
    form, known = read_format(format_, as_json, PLAIN), models()
    warn_of_faults(KINDS)
    chosen = known if kind is None else {name: known[name] for name in [_kind(kind, known)]}
    library = Library()
    rows = [row for name, model in chosen.items() for row in _rows(name, model, library)]
    if form is Format.JSON:
        print_json(rows)
    elif rows:
        short = [{**row, "description": _shortened(row["description"])} for row in rows]
        print_table("Documents", short)
    else:
        print("no documents")


def _kind(word: str, known: dict[str, type[Document]]) -> str:
    """Return the kind of a name in the singular or the plural."""
    plurals = {_plural(name): name for name in known}
    if word in known or word in plurals:
        return plurals.get(word, word)
    raise UsageError.unknown("kind of document", word, plurals)


def _plural(name: str) -> str:
    if name.endswith("y"):
        return f"{name[:-1]}ies"
    return name if name.endswith("s") else f"{name}s"


def _rows(kind: str, model: type[Document], library: Library) -> Iterator[dict[str, str]]:
    for name in library.names(model):
        file = library.find(model, name)
        if file is not None:
            robot, description = _robot_and_description(file, model, library)
            yield {
                "kind": kind,
                "name": name,
                "robot": robot,
                "description": description,
                "file": str(file),
            }


def _robot_and_description(file: Path, model: type[Document], library: Library) -> tuple[str, str]:
    """Return the robot and the description of a document, if readable."""
    try:
        document = library.read_sound_parts(file, model).document
    except DiagnosticsError:
        return "", "(has errors: cb validate lists them)"
    return str(getattr(document, "robot", "")), " ".join((document.description or "").split())


def _shortened(text: str) -> str:
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST].rpartition(' ')[0]} …"
