"""Policies as graphs: numbers derived from the counts, and the arcs that are drawn."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from cbdsl.documents.policy import PolicyDocument
from cbdsl.reporting.drawing.policy_transitions import decisions, policy_transitions
from tests.reporting.drawing.policies import POLICIES, WALKS, Walk, learned

SHARES = st.floats(0, 1)


@given(WALKS)
def test_starts_and_ends_of_episodes_follow_from_the_counts(walks: list[Walk]) -> None:
    known = {each.state: each for each in decisions(learned(walks))}
    assert {state: each.started for state, each in known.items() if each.started} == {
        "XX": len(walks)
    }
    came = [state for walk in walks for _, state in walk]
    for state, each in known.items():
        ends = sum(walk[-1][1] == state for walk in walks)
        goes_on = came.count(state) - ends
        assert each.met == came.count(state) + each.started
        # Ends and continuations are distinguished only by the difference of the counts.
        assert each.ended == ends and each.met - ends == goes_on + each.started


@given(POLICIES)
def test_shares_after_a_state_and_its_ends_sum_to_one(policy: PolicyDocument) -> None:
    for decision in decisions(policy):
        shares = [decision.share(state) for state in decision.after]
        assert all(0 <= share <= 1 for share in (*shares, decision.end))
        if decision.tried:
            assert abs(sum(shares) + decision.end - 1) < 1e-9
        else:
            assert not shares


@given(POLICIES, SHARES)
def test_graph_contains_exactly_the_arcs_above_the_share(
    policy: PolicyDocument, above: float
) -> None:
    graph = policy_transitions(policy, above, every=True)
    drawn = {(arc.source, arc.target) for arc in graph.arcs}
    for decision in graph.decisions:
        for state in decision.after:
            assert ((decision.state, state) in drawn) == (decision.share(state) > above)


@given(POLICIES, SHARES, SHARES)
def test_fewer_arcs_and_states_are_drawn_above_more(
    policy: PolicyDocument, one: float, other: float
) -> None:
    many, few = (policy_transitions(policy, above) for above in sorted((one, other)))
    assert set(few.arcs) <= set(many.arcs)
    assert {each.state for each in few.decisions} <= {each.state for each in many.decisions}


@given(POLICIES, SHARES)
def test_graph_contains_the_targets_of_its_arcs(policy: PolicyDocument, above: float) -> None:
    graph = policy_transitions(policy, above)
    shown = {decision.state for decision in graph.decisions}
    assert shown == {"XX"} | {arc.target for arc in graph.arcs}
    assert len(shown) + graph.left_out == len(decisions(policy))
    assert policy_transitions(policy, above, every=True).left_out == 0


def test_written_policy_has_all_its_patterns() -> None:
    policy = PolicyDocument(
        cbdsl=1,
        kind="policy",
        name="written",
        program="p",
        predicates=("a", "b"),
        policy={"**": "a", "0X": "b"},
    )
    graph = policy_transitions(policy)
    assert [(each.state, each.action) for each in graph.decisions] == [("**", "a"), ("0X", "b")]
    assert graph.arcs == () and all(each.value is None for each in graph.decisions)
