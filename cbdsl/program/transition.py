"""Transitions: the experience that running a program produces."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Transition:
    """One change of state, or one action that ended without any (Algorithm 1).

    Attributes:
        program: Program with this state.
        depth: Depth of use: 0 for the main program, 1 for a program that it uses, and so on.
        time: Simulated time at its end, s.
        state: Predicates before, one character per member.
        action: Name of the action.
        next_state: Predicates after; equal to ``state`` if the action ran out of time.
        ticks: Number of control ticks of the action.
        reward: Reward (Eq 4.4).
        rewarding: Members that earned the reward.
        allocation: Allocation of a schema's action; empty without one.
        features: Defined features by name, in SI, when the action was chosen.
        use: Names of the actions that lead to the program, parted by dots; empty for the main one.
        reason: Reason that the program states for a failure in ``next_state``; empty otherwise.
        stuck: Members at rest beyond their tolerance in ``next_state``.
    """

    program: str
    depth: int
    time: float
    state: str
    action: str
    next_state: str
    ticks: int
    reward: int
    rewarding: tuple[str, ...] = ()
    allocation: str = ""
    features: Mapping[str, float] = field(default_factory=dict)
    use: str = ""
    reason: str = ""
    stuck: tuple[str, ...] = ()

    @property
    def title(self) -> str:
        """Name of the program, and of its use if that differs."""
        return title_of(self.program, self.use)


def title_of(program: str, use: str) -> str:
    """Return the name of a program, and of its use if that differs.

    Args:
        program: Name of the program.
        use: Names of the actions that lead to it, parted by dots; empty for the main program.
    """
    # Examples: for the program ``reach``, the use ``pick.reach`` is its own title, and the use
    # ``pick.near`` has the title ``pick.near (reach)``.
    if use in ("", program):
        return program
    return use if use.endswith(f".{program}") else f"{use} ({program})"
