"""Policies in the language of Graphviz."""

from __future__ import annotations

from collections.abc import Iterator
from xml.sax.saxutils import escape

from cbdsl.reporting.drawing.pictogram import LETTERS
from cbdsl.reporting.drawing.policy_graph import Decision, PolicyGraph
from cbdsl.reporting.drawing.policy_words import facts, notes, percent, title

_STYLE = "node [shape=plain fontname=sans fontsize=11]", "edge [fontname=sans fontsize=10]"


def policy_dot(graph: PolicyGraph) -> str:
    """A policy as DOT: states are rows of coloured letters, arcs have their shares."""
    lines = (f"label={_quoted(title(graph), *notes(graph))} labeljust=l", *_STYLE, *_body(graph))
    body = "\n".join(f"  {line}" for line in lines)
    return f"digraph {_quoted(graph.name)} {{\n{body}\n}}\n"


def _body(graph: PolicyGraph) -> Iterator[str]:
    for decision in graph.decisions:
        yield f"{_quoted(decision.state)} [label=<{_label(graph, decision)}>]"
        if decision.started:
            yield f"{_quoted('start ' + decision.state)} [shape=point width=0.1]"
            yield f"{_quoted('start ' + decision.state)} -> {_quoted(decision.state)}"
    for arc in graph.arcs:
        look = f"label={_quoted(percent(arc.share))} penwidth={0.8 + 2.2 * arc.share:.1f}"
        yield f"{_quoted(arc.source)} -> {_quoted(arc.target)} [{look}]"


def _label(graph: PolicyGraph, decision: Decision) -> str:
    """A table, as Graphviz takes it for HTML: letters, then the action, then numbers."""
    cells = "".join(_cell(letter, member in graph.programs) for letter, member in
                    zip(decision.state, graph.members, strict=False))  # fmt: skip
    lines = [f"<B>{escape(decision.action)}</B>"] if decision.action else []
    lines += [escape(fact) for fact in facts(graph, decision)]
    frame = 2 if decision.end > graph.above else 1
    rows = "".join(f"<TR><TD>{line}</TD></TR>" for line in lines)
    letters = f'<TABLE BORDER="0" CELLSPACING="3"><TR>{cells}</TR></TABLE>'
    return (
        f'<TABLE BORDER="{frame}" CELLBORDER="0" CELLSPACING="0" STYLE="ROUNDED">'
        f"<TR><TD>{letters}</TD></TR>{rows}</TABLE>"
    )


def _cell(letter: str, program: bool) -> str:
    look = LETTERS[letter]
    return (
        f'<TD BORDER="{2 if program else 1}" BGCOLOR="{look.paper}">'
        f'<FONT COLOR="{look.ink}">{look.symbol}</FONT></TD>'
    )


def _quoted(*lines: str) -> str:
    escaped = (line.replace("\\", r"\\").replace('"', r"\"") for line in lines)
    return '"' + r"\n".join(escaped) + '"'
