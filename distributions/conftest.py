"""Fixtures of cbdsl's tests, for the tests of its plug-ins."""

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
from tests.reporting.conftest import kept, play, record, recorded

__all__ = [
    "bullet",
    "checked",
    "dexter",
    "kept",
    "kinematics",
    "library",
    "play",
    "pytest_collection_modifyitems",
    "pytest_make_collect_report",
    "pytest_runtest_makereport",
    "record",
    "recorded",
    "stage",
    "urdf",
]
