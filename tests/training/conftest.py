"""A finished trial of the toy runner."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.training.toy import EPISODES, take


@pytest.fixture(scope="module")
def unbroken(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a trial that nothing interrupted."""
    folder = tmp_path_factory.mktemp("unbroken")
    take(folder / "policy.yaml", EPISODES)
    return folder
