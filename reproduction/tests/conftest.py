"""Fixtures of cbdsl's tests, for the tests of this package."""

from __future__ import annotations

from tests.conftest import (
    bullet,
    checked,
    dexter,
    kinematics,
    library,
    pytest_collection_modifyitems,
    pytest_make_collect_report,
    pytest_runtest_makereport,
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
    "pytest_make_collect_report",
    "pytest_runtest_makereport",
    "stage",
    "urdf",
]
