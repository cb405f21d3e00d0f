"""Graph of a program's automaton: its steps, its ends, and the exits between them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from textwrap import shorten, wrap

from cbdsl.program.transition import title_of
from cbdsl.program.uses import of_use
from cbdsl.reporting.automaton_text import AutomatonData
from cbdsl.reporting.drawing.graph import Edge, Graph, Outline, TextLine, Vertex

# Width of a label, in letters, and its largest number of lines; the same for each exit.
_WIDTH, _LINES, _OF_EXIT = 30, 6, 2


def automaton_graph(name: str, automata: Mapping[str, AutomatonData], use: str = "") -> Graph:
    """Return the graph of a program; the programs that its steps run are graphs within its nodes.

    Args:
        name: Name of the program.
        automata: Automata of the program and of its used programs, as by ``automata``.
        use: Names of the actions that lead to the program, parted by dots.
    """
    title = title_of(name, use)
    key = title if title in automata else name
    inner = {}
    for step in automata[key]["steps"]:
        below = f"{use}.{step['action']}" if use else step["action"]
        if step["program"] and of_use(automata, step["program"], below) is not None:
            inner[step["step"]] = automaton_graph(step["program"], automata, below)
    return graph_of_steps(key, automata[key], inner)


def graph_of_steps(title: str, automaton: AutomatonData, inner: Mapping[str, Graph]) -> Graph:
    """Return the graph of an automaton, with graphs within its nodes by the names of steps."""
    edges = tuple(_edges(automaton))
    steps = [_step(automaton, step, inner.get(step["step"])) for step in automaton["steps"]]
    ends = {each.target for each in edges}.difference(step.key for step in steps)
    return Graph(
        name=title,
        title=title,
        nodes=(*steps, *(Vertex(end, Outline.END, (TextLine(end),)) for end in sorted(ends))),
        edges=edges,
        members=(),
    )


def _step(automaton: AutomatonData, step: AutomatonData, inner: Graph | None) -> Vertex:
    does = f"runs {step['program']}" if step["program"] else step["action"]
    below = wrap(does, _WIDTH) if does != step["step"] else []
    exits = "; ".join(f"{each['when']}: {each['to']}" for each in step["exits"])
    return Vertex(
        key=step["step"],
        shape=Outline.ACTION,
        lines=(TextLine(step["step"], "name"), *map(TextLine, below)),
        tooltip=f"{step['step']}: {exits or 'no exits'}.",
        started=step["step"] == automaton["start"],
        inner=inner,
    )


def _edges(automaton: AutomatonData) -> Iterator[Edge]:
    """Yield an edge for all exits between two nodes, with their conditions as its label."""
    for step in automaton["steps"]:
        ways: dict[str, list[str]] = {}
        for each in step["exits"]:
            to, reason = each["to"], ""
            if to.startswith("fail "):
                to, reason = to.split(" ", 1)
            when = shorten(each["when"], _WIDTH * _OF_EXIT, placeholder=" …")
            ways.setdefault(to, []).extend(wrap(f"{when}: {reason}" if reason else when, _WIDTH))
        ways.pop(step["step"], None)  # it goes on
        for to, lines in ways.items():
            shown = lines if len(lines) <= _LINES else [*lines[: _LINES - 1], "…"]
            yield Edge(step["step"], to, "\n".join(shown))
