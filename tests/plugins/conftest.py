"""The package of this folder, as if it were installed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.plugins.installed import installed, on_path, refresh


@pytest.fixture(scope="session")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the package's metadata, which its modules are linked into."""
    return installed(Path(__file__).parent / "package", tmp_path_factory.mktemp("site"))


@pytest.fixture(scope="module", autouse=True)
def demo(site: Path) -> Iterator[None]:
    """Every test of this folder has the package."""
    with on_path(site):
        refresh()
        yield
    refresh()


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    """A further folder of packages, for faulty ones; forgotten after each test."""
    with on_path(tmp_path):
        yield tmp_path
    refresh()
