"""Transition diagrams of greedy policies, drawn as ``cb show policy`` draws any policy."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from cbdsl.documents.policy import PolicyDocument
from cbdsl.learning.experience import Experience
from cbdsl.learning.transition_counts import TransitionCounts
from cbdsl.program.checked import CheckedProgram
from cbdsl.reporting.drawing.policy_graph import policy_graph
from cbdsl.reporting.drawing.policy_transitions import PolicyTransitions, policy_transitions
from cbdsl.reporting.drawing.svg import svg


@dataclass(frozen=True)
class Diagram:
    """A transition diagram.

    Attributes:
        name: of its file, without suffix.
        title: what it shows.
        graph: what is drawn.
    """

    name: str
    title: str
    graph: PolicyTransitions

    def data(self) -> dict[str, object]:
        """The data of the diagram, for scripts."""
        action = {decision.state: decision.action for decision in self.graph.decisions}
        return {
            "arcs": [
                [arc.source, action[arc.source], arc.target, round(arc.share, 4)]
                for arc in self.graph.arcs
            ]
        }

    def svg(self) -> str:
        """The picture, as the text of an SVG file."""
        return svg(policy_graph(self.graph))


def graph_of(
    name: str, program: CheckedProgram, experiences: Sequence[Experience]
) -> PolicyTransitions:
    """The graph of a policy, by the episodes that it ran without exploring.

    Args:
        name: of the policy.
        program: that it is for.
        experiences: the episodes.
    """
    counts = TransitionCounts()
    for each in (step for experience in experiences for step in experience.transitions):
        counts.add(each.state, each.action, each.next_state)
    transitions = dict(counts.items())
    policy = PolicyDocument(
        cbdsl=1,
        kind="policy",
        name=name,
        program=program.name,
        predicates=program.members,
        # Of a greedy policy there is one action for each state.
        policy={state: next(iter(actions)) for state, actions in transitions.items()},
        transitions=transitions,
    )
    programs = [action.name for action in program.actions if action.program is not None]
    return policy_transitions(policy, programs=programs, rewarded=_rewarded(experiences))


def _rewarded(experiences: Sequence[Experience]) -> Collection[str]:
    """The states in which every episode that ended there was rewarded."""
    ends = [(each.transitions[-1].next_state, each.reward > 0) for each in experiences]
    return {state for state, _ in ends} - {state for state, reward in ends if not reward}
