"""The three series of trials that learn handedness (Section 5.3.1.1), as data."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class HandednessSeries:
    """Trials of one learner, each from zero.

    Attributes:
        name: of the learner, and of the files of its trials.
        label: how tables and pictures call it.
        constrained: episodes of a first stage with the right arm alone.
        trials, episodes: as many as the source has.
    """

    name: str
    label: str
    constrained: int = 0
    trials: int = 100
    episodes: int = 200


#: Every allocation an action, without compositions; what is seen is a part of the state.
FLAT = HandednessSeries("flat", "flat")
#: What to do and with what, at once.
CONCURRENT = HandednessSeries("concurrent", "concurrent")
#: First what to do, then with what.
STAGED = HandednessSeries("staged", "staged", constrained=25)
