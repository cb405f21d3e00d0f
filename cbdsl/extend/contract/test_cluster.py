"""Contract of clusters: an address without a scheduler is refused by name."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from cbdsl.diagnostics.errors import UsageError
from cbdsl.training.side_by_side import CLUSTERS


@pytest.mark.parametrize("name", CLUSTERS.usable_names())
def test_address_without_a_scheduler_is_refused_by_name(name: str, tmp_path: Path) -> None:
    task: Any = SimpleNamespace(path=tmp_path / "any.yaml")
    with pytest.raises(UsageError, match="nowhere://here:1"):
        CLUSTERS.get(name)([task], "nowhere://here:1", task)
