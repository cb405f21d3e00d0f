"""``cb show meta-catalog``: stable pairs of objects as text, data or a graph, and plans."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.api.reading.clean import require_clean
from cbdsl.cli.output.terminal import print_json
from cbdsl.cli.show.formats import PICTURED, Format, Json, read_format
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.meta_catalog import MetaCatalogDocument
from cbdsl.reporting.text.meta_catalog_text import meta_catalog_text, stack_command
from cbdsl.yaml_text.library import Library

if TYPE_CHECKING:
    from cbdsl.learning.catalogs.stack_plan import StackPlan

MetaCatalog = Annotated[
    str, typer.Argument(metavar="FILE|NAME", help="Meta-catalog: file or name.")
]
FormatOption = Annotated[
    str, typer.Option("--format", help="Output format: text or json; svg for the graph.")
]
Graph = Annotated[bool, typer.Option("--svg", help="Short for --format svg.")]
Stack = Annotated[
    int | None, typer.Option("--stack", min=2, help="Number of objects of a stack to plan.")
]
Of = Annotated[
    str | None,
    typer.Option("--of", metavar="THING,...", help="With --stack: available objects [all]."),
]


def show_meta_catalog(
    name: MetaCatalog,
    *,
    format_: FormatOption = "text",
    svg: Graph = False,
    stack: Stack = None,
    of: Of = None,
    as_json: Json = False,
) -> None:
    """Show the relations between objects: counts, probabilities, and constellations.

    With --stack, print the most probable stack of the given height, bottom object first.
    """
    from cbdsl.reporting.drawing.meta_catalog_graph import meta_catalog_graph

    if of is not None and stack is None:
        raise UsageError("--of means nothing without --stack")
    form = read_format("svg" if svg else format_, as_json, PICTURED)
    catalog = read_meta_catalog(name)
    if stack is not None:
        _print_plan(catalog, plan(catalog, stack, of), as_json=form is Format.JSON)
    elif form is Format.SVG:
        print(meta_catalog_graph(catalog), end="")
    elif form is Format.JSON:
        print_json(catalog.model_dump(mode="json", by_alias=True, exclude_none=True))
    else:
        print(meta_catalog_text(catalog), end="")


def plan(catalog: MetaCatalogDocument, height: int, of: str | None) -> StackPlan:
    """Return the most probable stack of a given height.

    Raises:
        UsageError: An object is unknown, or no such stack is known.
    """
    from cbdsl.learning.catalogs.stack_plan import plan_stack
    from cbdsl.learning.catalogs.thing_graph import support_graph

    things = None if of is None else of.split(",")
    for thing in things or ():
        if thing not in catalog.things:
            raise UsageError.unknown("thing", thing, catalog.things)
    try:
        return plan_stack(support_graph(catalog, things), height)
    except ValueError as error:
        raise UsageError(f"{catalog.name}: {error}") from error


def _print_plan(catalog: MetaCatalogDocument, known: StackPlan, *, as_json: bool) -> None:
    channels = [catalog.things[name].feature for name in known.order]
    if as_json:
        print_json({**known._asdict(), "features": channels})
        return
    print(f"{' < '.join(known.order)}: stands with {known.probability:.2f}")
    command = stack_command(channels)
    if command is not None:
        print(command)


def read_meta_catalog(name: str) -> MetaCatalogDocument:
    """Return a meta-catalog without errors, by its name or file.

    Raises:
        DiagnosticsError: The document has errors.
        UsageError: There is no such document.
    """
    library = Library()
    file = library.locate(MetaCatalogDocument, name)
    require_clean(file, library)
    return library.read(file, MetaCatalogDocument).document
