"""Graphs in the language of Graphviz."""

from __future__ import annotations

from collections.abc import Iterator
from textwrap import indent

from cbdsl.reporting.drawing.graph import Box, Graph

_STYLE = "rankdir=LR", "compound=true", "node [fontname=sans fontsize=11]", "edge [fontname=sans]"


def dot(graph: Graph) -> str:
    """A graph as DOT, programs within it as clusters."""
    body = indent("\n".join((*_STYLE, *_cluster(graph, "p"))), "  ")
    return f"digraph {_text(graph.name)} {{\n{body}\n}}\n"


def _cluster(graph: Graph, key: str) -> Iterator[str]:
    """One program; ``key`` makes its nodes distinct from those of others."""
    label = graph.name if graph.background is None else f"{graph.name}; below: {graph.background}"
    yield f"subgraph cluster_{key} {{"
    yield f"  label={_text(label)}"
    yield f"  {key} [shape=diamond label={_text('state of', *graph.members)}]"
    for place, box in enumerate(graph.boxes):
        yield from (f"  {line}" for line in _action(box, f"{key}_{place}", key))
    if graph.coverage.undecided:
        yield f"  {key}_end [shape=doublecircle label=end]"
        yield f"  {key} -> {key}_end [label={_text('any other')}]"
    yield "}"
    for place, box in enumerate(graph.boxes):
        if box.inner is not None:
            yield from _cluster(box.inner, f"{key}_{place}_p")
            yield f"{key}_{place} -> {key}_{place}_p [style=dotted lhead=cluster_{key}_{place}_p]"


def _action(box: Box, key: str, state: str) -> Iterator[str]:
    style = "solid" if box.patterns else "dashed"
    reward = ["can be rewarded"] if box.rewarded else []
    yield f"{key} [shape=box style={style} label={_text(box.name, *box.lines, *reward)}]"
    for number, pattern in enumerate(box.patterns):
        yield f"{key}_{number} [shape=oval label={_text(pattern)}]"
        yield f"{state} -> {key}_{number} -> {key}"
    if box.patterns:
        yield f"{key} -> {state} [style=dashed constraint=false]"


def _text(*lines: str) -> str:
    """Lines of a label, quoted."""
    escaped = (line.replace("\\", r"\\").replace('"', r"\"") for line in lines)
    return '"' + r"\n".join(escaped) + '"'
