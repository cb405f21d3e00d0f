"""Series of trials that learn handedness (Section 5.3.1.1), as data."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class HandednessSeries:
    """Trials of one learner, each from zero.

    Attributes:
        name: Name of the learner, and of the files of its trials.
        label: Label in tables and pictures.
        constrained: Number of episodes of a first stage with the right arm alone.
        exploring: Number of episodes in which abstract actions are explored; ``None`` for all.
        trials, episodes: Numbers of trials and episodes, as in the source.
    """

    name: str
    label: str
    constrained: int = 0
    exploring: int | None = None
    trials: int = 100
    episodes: int = 200


#: Each allocation is an action, without compositions; visual features are part of the state.
FLAT = HandednessSeries("flat", "flat")
#: Actions and allocations are learned simultaneously.
CONCURRENT = HandednessSeries("concurrent", "concurrent")
#: The same, with as many episodes that explore actions as the staged learner has.
BRIEF = HandednessSeries("concurrent_brief", "concurrent, exploring for 25", exploring=25)
#: Actions are learned first, then allocations.
STAGED = HandednessSeries("staged", "staged", constrained=25)
