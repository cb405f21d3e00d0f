"""Contacts of fingertips with things, as the simulator knows them and the robot does not."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.backends.staging.engine import Engine
    from cbdsl.documents.stage import StageDocument
    from cbdsl.sensing.observation import Cell


def shown(truth: Engine, stage: StageDocument) -> list[str]:
    """Return the names of the objects in the world that are no fixtures of its stage."""
    return [name for name in truth.names() if name not in stage.fixtures]


def touching(truth: Engine, names: Iterable[str]) -> frozenset[Cell]:
    """Return fingertips, as (hand, finger), that touch any of some objects, each counted once."""
    return frozenset(cell for name in names for cell in truth.touching(name))
