"""Dexter without physics."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from tests.backends.conftest import URDF


@pytest.fixture
def backend(dexter: RobotDocument) -> Iterator[KinematicBackend]:
    backend = KinematicBackend(dexter, URDF)
    yield backend
    backend.close()


@pytest.fixture
def quiet(dexter: RobotDocument) -> Iterator[KinematicBackend]:
    """A backend whose load cells have no noise."""
    contact = dexter.contact.model_copy(update={"noise": 0.0})
    backend = KinematicBackend(dexter.model_copy(update={"contact": contact}), URDF)
    yield backend
    backend.close()


def begin(backend: KinematicBackend, stage: StageDocument, seed: int = 0, **values: Any) -> None:
    backend.reset(stage, values.get("context"), np.random.default_rng(seed))
