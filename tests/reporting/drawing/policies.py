"""Policies of random walks, for tests of drawings."""

from __future__ import annotations

from collections import Counter, defaultdict

from hypothesis import strategies as st

from cbdsl.documents.policy import Curve, PolicyDocument

MEMBERS = ("searchtrack", "reach")
ACTIONS = ("reach", "searchtrack", "reach ◁ searchtrack")

Walk = list[tuple[str, str]]


def learned(walks: list[Walk], start: str = "XX") -> PolicyDocument:
    """Return the policy learned from walks: actions and next states, by episode."""
    counts: dict[str, dict[str, Counter[str]]] = defaultdict(lambda: defaultdict(Counter))
    for walk in walks:
        state = start
        for action, after in walk:
            counts[state][action][after] += 1
            state = after
    most = {s: max(actions, key=lambda a: actions[a].total()) for s, actions in counts.items()}
    return PolicyDocument.model_validate(
        {
            "cbdsl": 1,
            "kind": "policy",
            "name": "walked",
            "program": "walking",
            "predicates": MEMBERS,
            "policy": most,
            "values": {state: {action: 0.5} for state, action in most.items()},
            "transitions": {
                state: {action: dict(after) for action, after in actions.items()}
                for state, actions in counts.items()
            },
            "curve": Curve(
                context=("only",) * len(walks),
                reward=(1,) * len(walks),
                transitions=tuple(map(len, walks)),
                ticks=(1,) * len(walks),
            ).model_dump(),
        }
    )


# No walk returns to its start state: all predicates are X only before the first action.
_STATES = st.text("X01-", min_size=2, max_size=2).filter(lambda state: state != "XX")
WALKS = st.lists(
    st.lists(st.tuples(st.sampled_from(ACTIONS), _STATES), min_size=1, max_size=12),
    min_size=1,
    max_size=12,
)
POLICIES = WALKS.map(learned)
