"""``cb show schema``: the trees of a schema, as text, as data, or as a picture."""

from __future__ import annotations

from collections.abc import Iterator
from difflib import unified_diff
from typing import Annotated

import typer

from cbdsl.cli.output.terminal import print_json
from cbdsl.cli.show.formats import Format, Json, drawing, read_format
from cbdsl.diagnostics.counting import count
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.schema import ChoiceQuestion, ChoiceTree, RewardQuestion, SchemaDocument
from cbdsl.reporting.drawing.schema_graph import schema_graph
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
    name: Schema, against: Against = None, format_: FormatOption = "text", as_json: Json = False
) -> None:
    """Show the allocation of resources by a schema, and its contexts without expected reward.

    --against prints the lines that differ from another schema: - for its lines, + for those of the
    first.
    """
    form = read_format(format_, as_json)
    if against is not None and form is not Format.TEXT:
        raise UsageError("--against compares the texts of two schemas: leave out --format")
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


def schema_text(schema: SchemaDocument) -> str:
    """Text of a schema: its features and allocations, and its trees."""
    return "\n".join(_lines(schema)) + "\n"


def _lines(schema: SchemaDocument) -> Iterator[str]:
    yield f"{schema.name}, a schema of {schema.program} under policy {schema.policy}"
    for name, action in schema.actions.items():
        yield f"  action      {name} = a({action.potential}, {action.in_}, {action.out})"
    for name, signal in schema.features.items():
        yield f"  feature     {name} is {signal}"
    for name, values in schema.allocations.items():
        yield f"  allocation  {name}: {', '.join(f'{key} {v}' for key, v in values.items())}"
    if schema.provenance is not None:
        known = schema.provenance
        where = f"{known.stage.name} ({known.backend})"
        yield f"  learned     {count(known.episodes, 'episode')} on {where}, seed {known.seed}"
    if schema.reward is not None:
        yield f"\nReward is likely? Below {schema.least_reward:g} nothing is begun"
        yield from _tree(schema.reward, "  ")
        if schema.tried:
            yield "  unknown, and tried, outside of these ranges by a tenth of them:"
        for name, (low, high) in schema.tried.items():
            yield f"    {name} from {low:g} to {high:g}"
    yield "\nWhich resources first?"
    yield from _tree(schema.choose, "  ")
    yield f"  where a feature is undefined: {_answer(schema.otherwise)}"


def _tree(tree: ChoiceTree | RewardQuestion | float, margin: str) -> Iterator[str]:
    """Yield the lines of a question with both of its branches, or of an answer."""
    if not isinstance(tree, (ChoiceQuestion, RewardQuestion)):
        yield f"{margin}{_answer(tree)}"
        return
    for word, below in ((f"{tree.if_}:", tree.then), ("else:", tree.else_)):
        if isinstance(below, (ChoiceQuestion, RewardQuestion)):
            yield f"{margin}{word}"
            yield from _tree(below, f"{margin}  ")
        else:
            yield f"{margin}{word} {_answer(below)}"


def _answer(answer: str | float | tuple[str, ...]) -> str:
    if isinstance(answer, float):
        return f"{100 * answer:.0f} %"
    return answer if isinstance(answer, str) else ", then ".join(answer) or "any"
