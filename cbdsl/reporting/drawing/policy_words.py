"""What is told of a policy in words, whatever it is drawn in."""

from __future__ import annotations

from collections.abc import Iterator

from cbdsl.errors.counting import count
from cbdsl.reporting.drawing.pictogram import in_words
from cbdsl.reporting.drawing.policy_graph import Decision, PolicyGraph


def percent(share: float) -> str:
    """A share as people read it."""
    return f"{100 * share:.0f} %"


def title(graph: PolicyGraph) -> str:
    """What is drawn."""
    learned = any(decision.value is not None for decision in graph.decisions)
    if graph.name == graph.program and not learned:
        return f"{graph.program}, the policy written in it"
    return f"{graph.name}, a policy of {graph.program}"


def facts(graph: PolicyGraph, decision: Decision) -> list[str]:
    """Short lines of numbers: the action's value and trials, and whether episodes end here."""
    lines = []
    if decision.value is not None:
        lines.append(f"Q {decision.value:.2f}, n {decision.tried}")
    if decision.end > graph.above:
        lines.append(f"{ending(graph, decision)} {percent(decision.end)}")
    return lines


def ending(graph: PolicyGraph, decision: Decision) -> str:
    """What it means that an episode ends in a state."""
    return "rewarded" if decision.state in graph.rewarded else "ends"


def sentence(graph: PolicyGraph, decision: Decision) -> str:
    """A state, what is done in it, and what follows."""
    parts = [f"{decision.state} ({in_words(decision.state, graph.members)}):"]
    if decision.action is not None:
        parts.append(f"{decision.action};")
    if decision.started:
        parts.append(f"{count(decision.started, 'episode')} began here;")
    if decision.end > graph.above:
        parts.append(f"{percent(decision.end)} {ending(graph, decision)};")
    own = [arc for arc in graph.arcs if arc.source == decision.state]
    parts += [f"{percent(arc.share)} to {arc.target};" for arc in own]
    return " ".join(parts)[:-1] + "."


def notes(graph: PolicyGraph) -> Iterator[str]:
    """How to read a drawing."""
    yield f"State, left to right: {', '.join(graph.members)}."
    if graph.programs:
        yield f"A double frame is a program's: {', '.join(sorted(graph.programs))}."
    if graph.arcs:
        yield (
            f"Arcs: what followed the policy's action in more than {percent(graph.above)} of the "
            "times."
        )
    if any(decision.value is not None for decision in graph.decisions):
        yield "Q: discounted reward to expect; n: times that the action was tried."
    if graph.left_out:
        yield f"{count(graph.left_out, 'more state')} that these arcs do not lead to."
