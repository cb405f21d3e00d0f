"""Graph of a schema: whether it begins, and with which resources (Figures 5.10, 5.11)."""

from __future__ import annotations

from collections.abc import Iterator

from cbdsl.documents.schema import (
    ChoiceQuestion,
    ChoiceTree,
    RewardQuestion,
    RewardTree,
    SchemaDocument,
)
from cbdsl.reporting.drawing.graph import Edge, Graph, Outline, TextLine, Vertex

_Parts = Iterator[Vertex | Edge]


def schema_graph(schema: SchemaDocument) -> Graph:
    """Return the trees of a schema, one below the other.

    If reward is likely enough, the tree of Pr(reward | pi, f) leads on to the tree of allocations.
    """
    parts = [*_reward(schema.reward, "reward", schema), *_choice(schema.choose, "choose")]
    nodes = tuple(part for part in parts if isinstance(part, Vertex))
    return Graph(
        name=schema.name,
        title=f"{schema.name}, a schema of {schema.program} under policy {schema.policy}",
        # The first node is the root of the tree of reward, or of the allocations if there is no
        # such tree.
        nodes=(nodes[0]._replace(started=True), *nodes[1:]),
        edges=tuple(part for part in parts if isinstance(part, Edge)),
        members=(),
        notes=(
            f"Where a feature is undefined: {', then '.join(schema.otherwise)}.",
            f"Undefined, before it moves, where reward is less likely than {schema.least_reward}.",
        ),
    )


def _reward(tree: RewardTree | None, key: str, schema: SchemaDocument) -> _Parts:
    """Yield the tree of reward, whose likely leaves lead to the tree of allocations."""
    if tree is None:
        return
    if isinstance(tree, RewardQuestion):
        yield _question(tree.if_, key)
        for word, below in (("yes", tree.then), ("no", tree.else_)):
            yield Edge(key, f"{key}_{word}", word)
            yield from _reward(below, f"{key}_{word}", schema)
        return
    # An unlikely reward leaves the program undefined, shown as its predicate `-`, before it moves.
    likely = tree >= schema.least_reward
    words = f"reward {100 * tree:.0f} %"
    lines = (TextLine(words, "reward" if likely else ""), *([] if likely else [TextLine("-")]))
    yield Vertex(key, Outline.PATTERN if likely else Outline.END, lines, tooltip=f"{words}.")
    if likely:
        yield Edge(key, "choose")


def _choice(tree: ChoiceTree, key: str) -> _Parts:
    """Yield the tree of allocations."""
    if isinstance(tree, ChoiceQuestion):
        yield _question(tree.if_, key)
        for word, below in (("yes", tree.then), ("no", tree.else_)):
            yield Edge(key, f"{key}_{word}", word)
            yield from _choice(below, f"{key}_{word}")
        return
    names = (tree,) if isinstance(tree, str) else tree
    first, *others = names or ("any",)
    lines = (TextLine(first, "name"), *(TextLine(f"then {name}") for name in others))
    yield Vertex(key, Outline.ACTION, lines, tooltip=f"{', then '.join(names)}.")


def _question(text: str, key: str) -> Vertex:
    return Vertex(key, Outline.SELECTOR, (TextLine(f"{text} ?"),), tooltip=f"{text}?")
