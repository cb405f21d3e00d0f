"""Outcomes of the actions of an exploration, and the features that they are told by."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

#: The action that costs nothing and tells nothing.
NOOP = "noop"


class FeatureForm(NamedTuple):
    """A feature as a model sees it.

    Attributes:
        name: in the catalog.
        unit: of its components.
        size: how many it has.
    """

    name: str
    unit: str
    size: int


class ActionOutcome(NamedTuple):
    """Outcome of one action.

    Attributes:
        action: its name.
        rewarded: whether it was rewarded by Eq 4.4.
        features: components of the features that were defined at its activation, in SI, by name.
        opened: actions that it made possible, such as the inspection of a mark that was seen.
        ahead: features of each known action that were defined when it was over.
        ending: how it ended, as a sentence.
        failed: whether it could not be run.
        sim_seconds: how long it took.
    """

    action: str
    rewarded: bool = False
    features: Mapping[str, tuple[float, ...]] = {}
    opened: tuple[str, ...] = ()
    ahead: Mapping[str, Mapping[str, tuple[float, ...]]] = {}
    ending: str = ""
    failed: bool = False
    sim_seconds: float = 0.0
