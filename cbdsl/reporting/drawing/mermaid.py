"""Graphs in the language of Mermaid, which Markdown on the web often renders."""

from __future__ import annotations

from collections.abc import Iterator

from cbdsl.reporting.drawing.graph import Edge, Graph, Outline, Vertex
from cbdsl.reporting.drawing.pictogram import symbols

# Mermaid parses labels as HTML and Markdown; these characters have a meaning there.
_SPECIAL = '"#&<>*_`-'
_BRACKETS = {Outline.SELECTOR: "{}", Outline.PATTERN: ("([", "])"), Outline.END: ("((", "))")}


def mermaid(graph: Graph) -> str:
    """Return a graph as a Mermaid flowchart, with graphs within it as subgraphs.

    A state in which episodes end is framed twice.
    """
    return "\n".join(("flowchart TD", *(f"  {line}" for line in _subgraph(graph, "p")))) + "\n"


def _subgraph(graph: Graph, key: str) -> Iterator[str]:
    """Yield one graph; ``key`` makes its nodes distinct from the nodes of other graphs."""
    yield f"subgraph {key}_box[{_quoted(graph.title)}]"
    # States such as `X-*1` are no identifiers of Mermaid, so that nodes are numbered.
    keys = {node.key: f"{key}_{place}" for place, node in enumerate(graph.nodes)}
    for node in graph.nodes:
        yield from (f"  {line}" for line in _node(node, keys[node.key]))
    for edge in graph.edges:
        yield f"  {keys[edge.source]} {_arrow(edge)} {keys[edge.target]}"
    yield "end"
    for node in graph.nodes:
        if node.inner is not None:
            yield from _subgraph(node.inner, f"{keys[node.key]}_p")
            yield f"{keys[node.key]} -.-> {keys[node.key]}_p_box"


def _node(node: Vertex, key: str) -> Iterator[str]:
    # Mermaid has no double frame. Its shape for subroutines, with double sides, stands for it.
    left, right = ("[[", "]]") if node.frame else _BRACKETS.get(node.shape, "[]")
    letters = [symbols(node.letters)] if node.letters else []
    yield f"{key}{left}{_quoted(*letters, *(line.text for line in node.lines))}{right}"
    if node.started:
        yield f"{key}_start(( )) --> {key}"


def _arrow(edge: Edge) -> str:
    return f"-->|{_quoted(*edge.label.splitlines())}|" if edge.label else "-->"


def _quoted(*lines: str) -> str:
    """Return the lines of a label in quotes, with special characters as character codes."""
    escaped = (
        "".join(f"#{ord(letter)};" if letter in _SPECIAL else letter for letter in line)
        for line in lines
    )
    return '"' + "<br>".join(escaped) + '"'
