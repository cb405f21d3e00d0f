"""Graphs in the language of Graphviz."""

from __future__ import annotations

from collections.abc import Iterator
from xml.sax.saxutils import escape

from cbdsl.reporting.drawing.graph import Graph, Outline, TextLine, Vertex
from cbdsl.reporting.drawing.pictogram import LETTERS

_STYLE = "compound=true", "node [fontname=sans fontsize=11]", "edge [fontname=sans fontsize=10]"
_SHAPES = {
    Outline.SELECTOR: "shape=diamond", Outline.PATTERN: "shape=oval", Outline.ACTION: "shape=box",
    Outline.END: "shape=doublecircle",
}  # fmt: skip


def dot(graph: Graph) -> str:
    """Return a graph as DOT, with graphs within it as clusters."""
    body = "\n".join(f"  {line}" for line in (*_STYLE, *_cluster(graph, "p")))
    return f"digraph {_quoted(graph.name)} {{\n{body}\n}}\n"


def _cluster(graph: Graph, key: str) -> Iterator[str]:
    """Yield one graph; ``key`` makes its nodes distinct from the nodes of other graphs."""
    yield f"subgraph cluster_{key} {{"
    yield f"  label={_quoted(graph.title, *graph.notes)} labeljust=l"
    # States such as `X-*1` are no identifiers of DOT, so that nodes are numbered.
    keys = {node.key: f"{key}_{place}" for place, node in enumerate(graph.nodes)}
    for node in graph.nodes:
        yield f"  {keys[node.key]} [{_look(graph, node)}]"
        if node.started:
            yield f"  {keys[node.key]}_start [shape=point width=0.1]"
            yield f"  {keys[node.key]}_start -> {keys[node.key]}"
    for edge in graph.edges:
        look = f"label={_quoted(*edge.label.splitlines())} penwidth={0.8 + 2.2 * edge.weight:.1f}"
        yield f"  {keys[edge.source]} -> {keys[edge.target]} [{look}]"
    yield "}"
    # Inner graphs follow after the closing brace. Within it, Graphviz would nest their clusters in
    # this one.
    for node in graph.nodes:
        if node.inner is not None:
            inner = f"{keys[node.key]}_p"
            yield from _cluster(node.inner, inner)
            # DOT has no edges to clusters. This edge leads to the first node, and `lhead` cuts it
            # at the border.
            yield f"{keys[node.key]} -> {inner}_0 [style=dotted lhead=cluster_{inner}]"


def _look(graph: Graph, node: Vertex) -> str:
    if node.letters:
        return f"shape=plain label=<{_table(graph, node)}>"
    return f"{_SHAPES[node.shape]} label={_quoted(*(line.text for line in node.lines))}"


def _table(graph: Graph, node: Vertex) -> str:
    """Return a table in Graphviz's HTML: letters, then the lines."""
    cells = "".join(_cell(letter, member in graph.programs) for letter, member in
                    zip(node.letters, graph.members, strict=False))  # fmt: skip
    rows = "".join(f"<TR><TD>{_line(line)}</TD></TR>" for line in node.lines)
    letters = f'<TABLE BORDER="0" CELLSPACING="3"><TR>{cells}</TR></TABLE>'
    return (
        f'<TABLE BORDER="{2 if node.frame else 1}" CELLBORDER="0" CELLSPACING="0" '
        f'STYLE="ROUNDED"><TR><TD>{letters}</TD></TR>{rows}</TABLE>'
    )


def _line(line: TextLine) -> str:
    return f"<B>{escape(line.text)}</B>" if line.kind == "action" else escape(line.text)


def _cell(letter: str, program: bool) -> str:
    look = LETTERS[letter]
    return (
        f'<TD BORDER="{2 if program else 1}" BGCOLOR="{look.paper}">'
        f'<FONT COLOR="{look.ink}">{look.symbol}</FONT></TD>'
    )


def _quoted(*lines: str) -> str:
    # Backslashes come first. In the reverse order, those of escaped quotes would be escaped again.
    escaped = (line.replace("\\", r"\\").replace('"', r"\"") for line in lines)
    return '"' + r"\n".join(escaped) + '"'
