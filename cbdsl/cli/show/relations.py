"""``cb show relations``: the tree that names contacts by their impedance, as text or as data."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.cli.show.formats import PLAIN, Format, Json, PlainFormat, read_format

if TYPE_CHECKING:
    from cbdsl.documents.relations import RelationsDocument, RelationTree

Relations = Annotated[str, typer.Argument(metavar="FILE|NAME", help="Relations: file or name.")]


def show_relations(name: Relations, format_: PlainFormat = "text", as_json: Json = False) -> None:
    """Show how the relation of two objects in contact is named by its impedance."""
    from cbdsl.api.reading.relations import read_relations
    from cbdsl.cli.output.terminal import print_json
    from cbdsl.yaml_text.library import Library

    form = read_format(format_, as_json, PLAIN)
    document = read_relations(name, Library()).document
    if form is Format.JSON:
        print_json(document.model_dump(mode="json", by_alias=True, exclude_none=True))
    else:
        print("\n".join(_lines(document)))


def _lines(document: RelationsDocument) -> Iterator[str]:
    from cbdsl.diagnostics.counting import count

    yield f"{document.name}: names of contacts that {document.robot} tests with {document.program}"
    if document.provenance is not None:
        origin = document.provenance
        yield f"  learned in {count(origin.episodes, 'episode')} on {origin.stage.name}"
        if origin.earlier is not None:
            yield f"  after {origin.earlier.name}"
    for relation, samples in document.samples.items():
        yield f"  {relation}: {count(len(samples), 'sample')}"
    yield ""
    yield from _tree(document.tree, "  ")


def _tree(tree: RelationTree, margin: str) -> Iterator[str]:
    """Yield the lines of a question with both of its branches, or of a name."""
    if isinstance(tree, str):
        yield f"{margin}{tree}"
        return
    for word, below in ((f"{tree.if_}:", tree.then), ("else:", tree.else_)):
        if isinstance(below, str):
            yield f"{margin}{word} {below}"
        else:
            yield f"{margin}{word}"
            yield from _tree(below, f"{margin}  ")
