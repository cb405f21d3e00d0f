"""All experiments, in the order of the source."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from cbdsl.reproduction.experiment import Experiment

# fmt: off
_ALL: tuple[Experiment, ...] = (
)
# fmt: on

#: One line per experiment.
EXPERIMENTS: Mapping[str, Experiment] = MappingProxyType({each.name: each for each in _ALL})
