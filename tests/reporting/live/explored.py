"""Explorations with scripted outcomes."""

from __future__ import annotations

from cbdsl.learning.catalogs.action_outcome import NOOP, ActionOutcome, FeatureForm
from cbdsl.learning.catalogs.catalog_exploration import CatalogConstants, CatalogExploration

PLACE = (FeatureForm("place", "m", 3),)


def exploration() -> CatalogExploration:
    """Return an exploration of two actions before its first action."""
    return CatalogExploration({"reach": PLACE, "lift": PLACE}, CatalogConstants())


def reached(x: float) -> ActionOutcome:
    """Return a rewarded reach at a place, where the object is seen afterwards."""
    place = {"place": (x, 0.2, -0.3)}
    return ActionOutcome("reach", rewarded=True, features=place, ahead={"reach": place})


def missed(x: float) -> ActionOutcome:
    """Return an unrewarded reach at a place, where the object is seen afterwards."""
    place = {"place": (x, 0.2, -0.3)}
    return ActionOutcome("reach", features=place, ahead={"reach": place})


def nothing() -> ActionOutcome:
    """Return a pause, after which no object is in sight."""
    return ActionOutcome(NOOP)
