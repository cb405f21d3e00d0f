"""Common fixtures of several packages: Dexter, and the shipped programs and stages."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import settings

from cbdsl.checking.program import check_program
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.program.checked import CheckedProgram
from cbdsl.yaml_text.library import Library
from tests.absent_parts import (
    pytest_collection_modifyitems,
    pytest_make_collect_report,
    pytest_runtest_makereport,
)

if TYPE_CHECKING:
    from cbdsl.backends.bullet.backend import BulletBackend

__all__ = [
    "pytest_collection_modifyitems",
    "pytest_make_collect_report",
    "pytest_runtest_makereport",
]

ROOT = Path(__file__).parents[1]

Checked = Callable[..., CheckedProgram]

# The duration of an example depends on the load of the machine and on first-time compilation.
# The same examples in every run: whether a change passes is decided by the change. All of them are
# tried by `make properties`.
settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.register_profile("exhaustive", deadline=None, max_examples=20_000)
settings.load_profile("repeatable")


@pytest.fixture(scope="session")
def library() -> Library:
    return Library(ROOT)


@pytest.fixture(scope="session")
def dexter(library: Library) -> RobotDocument:
    return library.read(library.locate(RobotDocument, "dexter"), RobotDocument).document


@pytest.fixture(scope="session")
def urdf(dexter: RobotDocument) -> Path:
    return ROOT / "robots" / dexter.model


@pytest.fixture(scope="session")
def kinematics(dexter: RobotDocument, urdf: Path) -> Kinematics:
    return Kinematics(dexter, urdf)


@pytest.fixture(scope="session")
def checked(library: Library) -> Checked:
    """Return a function for shipped programs by name, with values of their parameters.

    Programs are immutable, so that all tests of a process share them.
    """

    @cache
    def check(name: str, **values: str) -> CheckedProgram:
        return check_program(name, values, library)

    return check


@pytest.fixture(scope="session")
def stage(library: Library) -> Callable[[str], StageDocument]:
    """Return a function for shipped stages by name."""

    def read(name: str) -> StageDocument:
        return library.read(library.locate(StageDocument, name), StageDocument).document

    return read


@pytest.fixture(scope="session")
def bullet(dexter: RobotDocument, urdf: Path) -> Iterator[BulletBackend]:
    """Yield Dexter in PyBullet, with any renderer that works here."""
    from cbdsl.backends.bullet.backend import BulletBackend

    backend = BulletBackend(dexter, urdf)
    yield backend
    backend.close()
