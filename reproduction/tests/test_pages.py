"""Pages that name experiments."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from cbdsl_reproduction.registry import EXPERIMENTS
from tests.conftest import ROOT
from tests.test_docs import DOCS, IDS, PAGES


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_experiments_that_are_named_can_be_reproduced(page: Path) -> None:
    text = page.read_text("utf-8")
    for name in re.findall(r"`((?:fig|table|law)-[\w.-]+)`", text):
        assert name in EXPERIMENTS, name


def test_each_deviation_cites_evidence_that_exists() -> None:
    text = (DOCS / "deviations.md").read_text("utf-8")
    entries = [each for each in re.split(r"\n(?=- |\n)", text) if each.startswith("- **")]
    assert len(entries) > 100
    for entry in entries:
        cited = re.findall(r"`([^`\s]+)`", entry)
        files = [
            each for each in cited if re.match(r"(reproduction|tests|programs|knowledge)/", each)
        ]
        experiments = [each for each in cited if each in EXPERIMENTS]
        assert files or experiments, f"no evidence: {entry[:60]}"
        assert all((ROOT / each).exists() for each in files), entry[:60]
