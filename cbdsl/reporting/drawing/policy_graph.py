"""Graph of a policy: states, their actions, and the likely transitions between them."""

from __future__ import annotations

from collections.abc import Iterator

from cbdsl.diagnostics.counting import count
from cbdsl.reporting.drawing.graph import Edge, Graph, Outline, TextLine, Vertex
from cbdsl.reporting.drawing.pictogram import in_words
from cbdsl.reporting.drawing.policy_transitions import Decision, PolicyTransitions


def policy_graph(policy: PolicyTransitions) -> Graph:
    """Return the transition diagram of a policy, as in Figures 4.5, 4.7 and 4.10."""
    return Graph(
        name=policy.name,
        title=title(policy),
        nodes=tuple(_node(policy, decision) for decision in policy.decisions),
        edges=tuple(
            Edge(arc.source, arc.target, percent(arc.share), arc.share) for arc in policy.arcs
        ),
        members=policy.members,
        programs=policy.programs,
        notes=tuple(_notes(policy)),
    )


def _node(policy: PolicyTransitions, decision: Decision) -> Vertex:
    action = [TextLine(decision.action, "action")] if decision.action else []
    facts = [TextLine(fact, "fact") for fact in _facts(policy, decision)]
    frame = ""
    if decision.end > policy.above:
        frame = "ending rewarded" if decision.state in policy.rewarded else "ending"
    return Vertex(
        key=decision.state,
        shape=Outline.STATE,
        lines=(*action, *facts),
        letters=decision.state,
        tooltip=sentence(policy, decision),
        started=bool(decision.started),
        frame=frame,
    )


def percent(share: float) -> str:
    """Return a share as a percentage."""
    return f"{100 * share:.0f} %"


def title(policy: PolicyTransitions) -> str:
    """Return a title with the policy's name and its program's."""
    learned = any(decision.value is not None for decision in policy.decisions)
    if policy.name == policy.program and not learned:
        return f"{policy.program}, the policy written in it"
    return f"{policy.name}, a policy of {policy.program}"


def _facts(policy: PolicyTransitions, decision: Decision) -> Iterator[str]:
    """Yield the action's value and trials, and whether episodes end here."""
    if decision.value is not None:
        yield f"Q {decision.value:.2f}, n {decision.tried}"
    if decision.end > policy.above:
        yield f"{ending(policy, decision)} {percent(decision.end)}"


def ending(policy: PolicyTransitions, decision: Decision) -> str:
    """Return the word for an episode that ends in a state."""
    return "rewarded" if decision.state in policy.rewarded else "ends"


def sentence(policy: PolicyTransitions, decision: Decision) -> str:
    """Return a sentence about a state, its action, and the transitions out of it."""
    parts = [f"{decision.state} ({in_words(decision.state, policy.members)}):"]
    if decision.action is not None:
        parts.append(f"{decision.action};")
    if decision.started:
        parts.append(f"{count(decision.started, 'episode')} began here;")
    if decision.end > policy.above:
        parts.append(f"{percent(decision.end)} {ending(policy, decision)};")
    own = [arc for arc in policy.arcs if arc.source == decision.state]
    parts += [f"{percent(arc.share)} to {arc.target};" for arc in own]
    return " ".join(parts)[:-1] + "."


def _notes(policy: PolicyTransitions) -> Iterator[str]:
    """Yield notes for reading the diagram."""
    yield f"State, left to right: {', '.join(policy.members)}."
    if policy.programs:
        yield f"A double frame is a program's: {', '.join(sorted(policy.programs))}."
    if policy.arcs:
        yield (
            f"Arcs: what followed the policy's action in more than {percent(policy.above)} of the "
            "times."
        )
    if any(decision.value is not None for decision in policy.decisions):
        yield "Q: discounted reward to expect; n: times that the action was tried."
    if policy.left_out:
        yield f"{count(policy.left_out, 'more state')} that these arcs do not lead to."
