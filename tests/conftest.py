"""Common fixtures of several packages: Dexter, and the shipped programs and stages."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from importlib.util import find_spec
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

if TYPE_CHECKING:
    from cbdsl.backends.bullet.backend import BulletBackend

ROOT = Path(__file__).parents[1]

_HAS_BULLET = find_spec("pybullet") is not None
_NEEDS_BULLET = re.compile(r"^(?:import|from) (?:pybullet|cbdsl\.backends\.bullet)", re.MULTILINE)


def needing_bullet(folder: Path) -> list[str]:
    """Return the test files of a folder to leave out, because they need Bullet.

    It has no wheels from Python 3.14 on.
    """
    files = [] if _HAS_BULLET else sorted(folder.rglob("*.py"))
    return [str(file) for file in files if _NEEDS_BULLET.search(file.read_text("utf-8"))]


collect_ignore = needing_bullet(Path(__file__).parent)


def pytest_report_header() -> str | None:
    """Report the left-out tests."""
    left_out = f"without Bullet: {len(collect_ignore)} files and cases of it are left out"
    return None if _HAS_BULLET else left_out


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Skip cases of Bullet where it is not installed."""
    for item in [] if _HAS_BULLET else items:
        values = getattr(item, "callspec", None)
        if values is not None and "bullet" in {str(value) for value in values.params.values()}:
            item.add_marker(pytest.mark.skip(reason="needs Bullet"))


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
    """Return a function for shipped programs by name, with values of their parameters."""

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
