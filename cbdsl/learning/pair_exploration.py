"""Exploration of pairs: which thing to bring to which one next (Section 7.3)."""

from __future__ import annotations

import numpy as np

from cbdsl.learning.action_outcome import NOOP
from cbdsl.learning.catalog_exploration import CatalogExploration


class PairExploration(CatalogExploration):
    """EXPLORECATALOG over pairs, of which those come first that were hardly tried.

    A pair that never stood changes no model and has no value: without that, chance alone would
    say whether it was ever tried.
    """

    def choose(self, rng: np.random.Generator) -> str:
        """See ``Exploration.choose``."""
        tried = {name: self.affordances[name].tried for name in self.actions if name != NOOP}
        least = min(tried.values(), default=self.constants.least)
        if least >= self.constants.least:
            return super().choose(rng)
        fewest = [name for name, count in tried.items() if count == least]
        return fewest[int(rng.integers(len(fewest)))]
