"""Learning shipped knowledge again."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conftest import ROOT
from tests.relearn import learned, shipped

DOCUMENTS = sorted(ROOT.glob("knowledge/*/*.yaml"))


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_document_is_shipped_where_it_lies(path: Path) -> None:
    assert shipped(path)[1] == path


def test_documents_are_learned_after_those_that_they_use() -> None:
    known = learned()
    order = list(known)
    for key, each in known.items():
        assert all(order.index(used) < order.index(key) for used in each.uses & known.keys())
