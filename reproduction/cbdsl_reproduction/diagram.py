"""Transition diagrams of greedy policies, drawn as ``cb show policy`` draws any policy."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from cbdsl.api.documents import PolicyDocument
from cbdsl.api.drawing import PolicyTransitions, draw_policy, policy_transitions
from cbdsl.api.learning import Experience, TransitionCounts
from cbdsl.api.program import CheckedProgram


@dataclass(frozen=True)
class Diagram:
    """Transition diagram.

    Attributes:
        name: Name of its file, without suffix.
        title: Title of the diagram.
        graph: Drawn graph.
    """

    name: str
    title: str
    graph: PolicyTransitions

    def data(self) -> dict[str, object]:
        """Return the data of the diagram, for scripts."""
        action = {decision.state: decision.action for decision in self.graph.decisions}
        return {
            "arcs": [
                [arc.source, action[arc.source], arc.target, round(arc.share, 4)]
                for arc in self.graph.arcs
            ]
        }

    def svg(self) -> str:
        """Return the picture as the text of an SVG file."""
        return draw_policy(self.graph)


def graph_of(
    name: str, program: CheckedProgram, experiences: Sequence[Experience]
) -> PolicyTransitions:
    """Return the graph of a policy from its episodes without exploration.

    Args:
        name: Name of the policy.
        program: Program of the policy.
        experiences: Episodes under the policy.
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
        # A greedy policy has one action for each state.
        policy={state: next(iter(actions)) for state, actions in transitions.items()},
        transitions=transitions,
    )
    programs = [action.name for action in program.actions if action.program is not None]
    return policy_transitions(policy, programs=programs, rewarded=_rewarded(experiences))


def _rewarded(experiences: Sequence[Experience]) -> Collection[str]:
    """Return the final states in which all episodes that ended there were rewarded."""
    ends = [(each.transitions[-1].next_state, each.reward > 0) for each in experiences]
    return {state for state, _ in ends} - {state for state, reward in ends if not reward}
