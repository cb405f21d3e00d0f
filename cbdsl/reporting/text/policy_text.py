"""Policies as text for a terminal of 80 columns."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from textwrap import wrap

from cbdsl.diagnostics.counting import count
from cbdsl.documents.policy import PolicyDocument
from cbdsl.reporting.automaton_text import state_text
from cbdsl.reporting.drawing.pictogram import LETTERS
from cbdsl.reporting.drawing.policy_graph import ending, percent, title
from cbdsl.reporting.drawing.policy_transitions import Arc, Decision, PolicyTransitions, decisions

#: Kinds of members that are no controllers: ``program`` or ``condition``.
Kinds = Mapping[str, str]

_WIDTH = 80


def policy_text(policy: PolicyDocument, graph: PolicyTransitions, kinds: Kinds) -> str:
    """Return the action of a policy in every state, and the likely transitions, as text.

    Args:
        policy: Policy; all of its states are listed.
        graph: Transition graph of the policy; only its transitions are listed.
        kinds: Kinds of the policy's members.
    """
    return "\n".join(_policy(policy, graph, kinds)) + "\n"


def _policy(policy: PolicyDocument, graph: PolicyTransitions, kinds: Kinds) -> Iterator[str]:
    yield title(graph)
    yield from _item("state", ", ".join(policy.predicates))
    letters = [letter for letter in LETTERS if letter != "*" or "*" in "".join(policy.policy)]
    meanings = (f"{letter} {LETTERS[letter].meaning}" for letter in letters)
    yield from _item("letters", ", ".join(meanings))
    if policy.provenance is not None:
        known = policy.provenance
        where = f"{known.stage.name} ({known.backend})"
        yield from _item(
            "learned", f"{count(known.episodes, 'episode')} on {where}, seed {known.seed}"
        )
    if policy.curve is not None:
        hits = sum(reward > 0 for reward in policy.curve.reward)
        yield from _item("rewarded", f"{hits} of {count(len(policy.curve.reward), 'episode')}")
    for name, model in policy.models.items():
        yield from _item("model", f"{name} is {model}")
    learned = any(decision.value is not None for decision in decisions(policy))
    yield f"\nPolicy{' (Q: discounted reward to expect)' if learned else ''}"
    yield from _table(_rows(decisions(policy)))
    yield "\nStates in words"
    for each in decisions(policy):
        words = state_text(policy.predicates, each.state, kinds)
        yield from _item(each.state, words, len(each.state) + 2)
    if graph.arcs:
        yield f"\nWhat follows, above {percent(graph.above)}"
        yield from _tree(graph)


def _rows(known: Iterable[Decision]) -> Iterator[tuple[str, ...]]:
    yield "state", "action", "Q", "tried", "met", "ended"
    for each in known:
        value = "" if each.value is None else f"{each.value:.3f}"
        counts = (str(number or "") for number in (each.tried, each.met, each.ended))
        yield each.state, each.action or "", value, *counts


def _table(rows: Iterable[Sequence[str]]) -> Iterator[str]:
    """Yield the lines of a table; the first two columns are words, the others are numbers."""
    cells = list(rows)
    filled = [any(row[place] for row in cells[1:]) for place in range(len(cells[0]))]
    kept = [[cell for cell, keep in zip(row, filled, strict=True) if keep] for row in cells]
    widths = [max(map(len, column)) for column in zip(*kept, strict=True)]
    for row in kept:
        words = [
            cell.ljust(width) if place < 2 else cell.rjust(width)
            for place, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        yield f"  {'  '.join(words)}".rstrip()


def _tree(graph: PolicyTransitions) -> Iterator[str]:
    """Yield lines of states below their predecessors; expand each state at its first line."""
    known = {decision.state: decision for decision in graph.decisions}
    shown: set[str] = set()
    for decision in graph.decisions:
        if decision.started or decision.state not in shown:
            yield from _branch(graph, known, decision.state, "  ", "", shown)


def _branch(
    graph: PolicyTransitions,
    known: dict[str, Decision],
    state: str,
    margin: str,
    share: str,
    shown: set[str],
) -> Iterator[str]:
    # A state is expanded once, so that cycles of transitions end.
    again = state in shown
    shown.add(state)
    yield f"{margin}{share}{_node_text(graph, known[state], again)}"
    arcs: list[Arc] = [] if again else [arc for arc in graph.arcs if arc.source == state]
    below = margin.replace("├", "│").replace("└", " ")
    for arc in arcs:
        last = arc is arcs[-1]
        yield from _branch(
            graph, known, arc.target, below + ("└ " if last else "├ "),
            f"{percent(arc.share):>5} ", shown,
        )  # fmt: skip


def _node_text(graph: PolicyTransitions, decision: Decision, again: bool) -> str:
    if again:
        return f"{decision.state} (above)"
    parts = [decision.state, *([decision.action] if decision.action else [])]
    if decision.end > graph.above:
        parts.append(f"{ending(graph, decision)} {percent(decision.end)}")
    return "  ".join(parts)


def _item(name: str, value: str, width: int = 12) -> Iterator[str]:
    first, *others = wrap(value, _WIDTH - 2 - width) or [""]
    yield f"  {name:<{width}}{first}"
    yield from (f"  {'':{width}}{line}" for line in others)
