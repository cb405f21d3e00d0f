"""Dexter in PyBullet."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.documents.robot import RobotDocument
from tests.backends.conftest import URDF, sightless


@pytest.fixture(scope="session")
def backend(bullet: BulletBackend) -> BulletBackend:
    """Return a backend with any renderer that works here."""
    return bullet


@pytest.fixture(scope="session")
def blind(dexter: RobotDocument) -> Iterator[BulletBackend]:
    """Yield a backend without images, whose load cells have no noise."""
    backend = BulletBackend(sightless(dexter), URDF)
    yield backend
    backend.close()
