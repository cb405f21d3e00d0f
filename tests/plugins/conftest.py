"""The package of this folder, as if it were installed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.plugins.installed import installed, on_path, refresh


@pytest.fixture(scope="session")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the package's metadata, which its modules are linked into."""
    return installed(Path(__file__).parent / "package", tmp_path_factory.mktemp("site"))


@pytest.fixture(scope="module", autouse=True)
def demo(site: Path) -> Iterator[None]:
    """Provide the package to every test of this folder."""
    with on_path(site):
        refresh()
        yield
    refresh()


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    """Yield a further folder of packages, for faulty ones; forget it after each test."""
    with on_path(tmp_path):
        yield tmp_path
    refresh()
