"""Fixtures of cbdsl's tests, for the tests of this package."""

from __future__ import annotations

from pathlib import Path

from tests.conftest import (
    bullet,
    checked,
    dexter,
    kinematics,
    library,
    needing_bullet,
    pytest_collection_modifyitems,
    stage,
    urdf,
)
from tests.sensing.conftest import posture

__all__ = [
    "bullet",
    "checked",
    "dexter",
    "kinematics",
    "library",
    "posture",
    "pytest_collection_modifyitems",
    "stage",
    "urdf",
]

collect_ignore = needing_bullet(Path(__file__).parent)
