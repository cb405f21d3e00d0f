"""Dexter in MuJoCo."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl_mujoco.backend import MujocoBackend
from tests.backends.conftest import URDF, sightless


@pytest.fixture(scope="session")
def blind(dexter: RobotDocument) -> Iterator[MujocoBackend]:
    """Yield a backend without images, whose load cells have no noise."""
    backend = MujocoBackend(sightless(dexter), URDF)
    yield backend
    backend.close()
