"""Files of a robot of two joints."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.documents.stage import StageDocument
from tests.driven_robot import URDF


@pytest.fixture
def urdf(tmp_path: Path) -> Path:
    path = tmp_path / "rail.urdf"
    path.write_text(URDF)
    return path


@pytest.fixture
def stage() -> StageDocument:
    head = {"cbdsl": 1, "kind": "stage", "name": "bare", "robot": "rail"}
    return StageDocument.model_validate({**head, "contexts": {"only": {}}})
