"""Transitions without a robot."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from cbdsl.program.transition import Transition

Made = Callable[..., Transition]


@pytest.fixture(scope="session")
def made() -> Made:
    """Return a function for transitions of a program, rewarded at the second member's rest."""

    def make(state: str, action: str, after: str) -> Transition:
        earned = ("track",) if after[1] == "1" != state[1] else ()
        return Transition("searchtrack", 0, 0.0, state, action, after, 3, len(earned), earned)

    return make
