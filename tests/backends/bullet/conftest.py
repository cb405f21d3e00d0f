"""Dexter in PyBullet."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.documents.robot import RobotDocument
from tests.backends.conftest import URDF, sightless


@pytest.fixture(scope="session")
def backend(bullet: BulletBackend) -> BulletBackend:
    """A backend with whatever renderer works here."""
    return bullet


@pytest.fixture(scope="session")
def blind(dexter: RobotDocument) -> Iterator[BulletBackend]:
    """A backend that spends no time on images, with load cells that have no noise."""
    backend = BulletBackend(sightless(dexter), URDF)
    yield backend
    backend.close()
