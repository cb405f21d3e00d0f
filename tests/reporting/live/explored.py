"""Explorations whose outcomes are told, not acted."""

from __future__ import annotations

from cbdsl.learning.action_outcome import NOOP, ActionOutcome, FeatureForm
from cbdsl.learning.catalog_exploration import CatalogConstants, CatalogExploration

PLACE = (FeatureForm("place", "m", 3),)


def exploration() -> CatalogExploration:
    """An exploration of two actions before the first of them."""
    return CatalogExploration({"reach": PLACE, "lift": PLACE}, CatalogConstants())


def reached(x: float) -> ActionOutcome:
    """A rewarded reach at a place, which is seen there afterwards."""
    place = {"place": (x, 0.2, -0.3)}
    return ActionOutcome("reach", rewarded=True, features=place, ahead={"reach": place})


def missed(x: float) -> ActionOutcome:
    """A reach at a place without reward, after which a thing is seen there."""
    place = {"place": (x, 0.2, -0.3)}
    return ActionOutcome("reach", features=place, ahead={"reach": place})


def nothing() -> ActionOutcome:
    """A pause, after which nothing is in sight."""
    return ActionOutcome(NOOP)
