"""Graphs in the language of Mermaid, which Markdown on the web often renders."""

from __future__ import annotations

from collections.abc import Iterator

from cbdsl.reporting.drawing.graph import Box, Graph

# Labels are taken for HTML and Markdown; these would mean something there.
_SPECIAL = '"#&<>*_`-'


def mermaid(graph: Graph) -> str:
    """A graph as a Mermaid flowchart, programs within it as subgraphs."""
    return "\n".join(("flowchart LR", *(f"  {line}" for line in _subgraph(graph, "p")))) + "\n"


def _subgraph(graph: Graph, key: str) -> Iterator[str]:
    """One program; ``key`` makes its nodes distinct from those of others."""
    label = graph.name if graph.background is None else f"{graph.name}; below: {graph.background}"
    yield f"subgraph {key}_box[{quoted(label)}]"
    yield f"  {key}{{{quoted('state of', *graph.members)}}}"
    for place, box in enumerate(graph.boxes):
        yield from (f"  {line}" for line in _action(box, f"{key}_{place}", key))
    if graph.coverage.undecided:
        yield f"  {key} -->|any other| {key}_end((end))"
    yield "end"
    for place, box in enumerate(graph.boxes):
        if box.inner is not None:
            yield from _subgraph(box.inner, f"{key}_{place}_p")
            yield f"{key}_{place} -.-> {key}_{place}_p_box"


def _action(box: Box, key: str, state: str) -> Iterator[str]:
    reward = ["can be rewarded"] if box.rewarded else []
    yield f"{key}[{quoted(box.name, *box.lines, *reward)}]"
    for number, pattern in enumerate(box.patterns):
        yield f"{state} --> {key}_{number}([{quoted(pattern)}]) --> {key}"
    if box.patterns:
        yield f"{key} -.-> {state}"
    else:
        yield f"style {key} stroke-dasharray: 4"


def quoted(*lines: str) -> str:
    """Lines of a label in quotes, with what has a meaning in them as character codes."""
    escaped = (
        "".join(f"#{ord(letter)};" if letter in _SPECIAL else letter for letter in line)
        for line in lines
    )
    return '"' + "<br>".join(escaped) + '"'
