"""Policies in the language of Mermaid, which Markdown on the web often renders."""

from __future__ import annotations

from collections.abc import Iterator

from cbdsl.reporting.drawing.mermaid import quoted
from cbdsl.reporting.drawing.pictogram import symbols
from cbdsl.reporting.drawing.policy_graph import Decision, PolicyGraph
from cbdsl.reporting.drawing.policy_words import facts, percent


def policy_mermaid(graph: PolicyGraph) -> str:
    """A policy as a Mermaid flowchart: a state is a box, twice framed where episodes end in it."""
    return "\n".join(("flowchart TD", *(f"  {line}" for line in _body(graph)))) + "\n"


def _body(graph: PolicyGraph) -> Iterator[str]:
    keys = {decision.state: f"s{place}" for place, decision in enumerate(graph.decisions)}
    for decision in graph.decisions:
        key, label = keys[decision.state], _label(graph, decision)
        yield f"{key}[[{label}]]" if decision.end > graph.above else f"{key}[{label}]"
        if decision.started:
            yield f"{key}_start(( )) --> {key}"
    for arc in graph.arcs:
        label = quoted(percent(arc.share))
        yield f"{keys[arc.source]} -->|{label}| {keys[arc.target]}"


def _label(graph: PolicyGraph, decision: Decision) -> str:
    action = [decision.action] if decision.action else []
    return quoted(symbols(decision.state), *action, *facts(graph, decision))
