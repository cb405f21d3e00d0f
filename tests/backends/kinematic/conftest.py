"""Dexter without physics."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from tests.backends.conftest import URDF, exact


@pytest.fixture
def backend(dexter: RobotDocument) -> Iterator[KinematicBackend]:
    backend = KinematicBackend(dexter, URDF)
    yield backend
    backend.close()


@pytest.fixture
def quiet(dexter: RobotDocument) -> Iterator[KinematicBackend]:
    """Yield a backend with exact sensors."""
    backend = KinematicBackend(exact(dexter), URDF)
    yield backend
    backend.close()


def begin(backend: KinematicBackend, stage: StageDocument, seed: int = 0, **values: Any) -> None:
    backend.reset(stage, values.get("context"), np.random.default_rng(seed))
