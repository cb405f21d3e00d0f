"""All explorations, by the name of their algorithm."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cbdsl.learning.catalogs.catalog_exploration import CatalogExploration
from cbdsl.learning.catalogs.model_exploration import ModelExploration

#: Explorations by the name of their algorithm.
EXPLORATIONS: Mapping[str, type[Any]] = {
    "explore_catalog": CatalogExploration,
    "explore_models": ModelExploration,
}
