"""Exploration of pairs: the next object to bring to another one (Section 7.3)."""

from __future__ import annotations

import numpy as np

from cbdsl.learning.catalogs.action_outcome import NOOP
from cbdsl.learning.catalogs.catalog_exploration import CatalogExploration


class PairExploration(CatalogExploration):
    """EXPLORECATALOG over pairs, where the least-tried pairs come first.

    A pair that never stood changes no model and has no value. Without this rule, only chance would
    decide whether it is ever tried.
    """

    def choose(self, rng: np.random.Generator) -> str:
        """Return the next action (see ``Exploration.choose``)."""
        tried = {name: self.affordances[name].tried for name in self.actions if name != NOOP}
        least = min(tried.values(), default=self.constants.least)
        if least >= self.constants.least:
            return super().choose(rng)
        fewest = [name for name, count in tried.items() if count == least]
        return fewest[int(rng.integers(len(fewest)))]
