"""Outcomes of the actions of an exploration, and the features that predict them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

#: Action without cost and without information.
NOOP = "noop"


class FeatureForm(NamedTuple):
    """Form of a feature in an affordance model.

    Attributes:
        name: Name in the catalog.
        unit: Unit of the components.
        size: Number of components.
    """

    name: str
    unit: str
    size: int


class ActionOutcome(NamedTuple):
    """Outcome of one action.

    Attributes:
        action: Name of the action.
        rewarded: True if the action was rewarded by Eq 4.4.
        features: Components of the features that were defined at its activation, in SI, by name.
        opened: Actions that became possible, such as the inspection of a mark that was seen.
        ahead: Features of each known action that were defined when this action ended.
        ending: Description of the end, as a sentence.
        failed: True if the action could not be run.
        sim_seconds: Simulated duration, s.
    """

    action: str
    rewarded: bool = False
    features: Mapping[str, tuple[float, ...]] = {}
    opened: tuple[str, ...] = ()
    ahead: Mapping[str, Mapping[str, tuple[float, ...]]] = {}
    ending: str = ""
    failed: bool = False
    sim_seconds: float = 0.0
