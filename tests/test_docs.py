"""Every YAML block in the docs is a document without findings."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from cbdsl.checking.document import check_document

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCKS = [
    (page, text)
    for page in PAGES
    for text in re.findall(
        r"^```yaml\n(.*?)^```", page.read_text("utf-8"), re.DOTALL | re.MULTILINE
    )
]


@pytest.mark.parametrize(("page", "text"), BLOCKS, ids=[page.name for page, _ in BLOCKS])
def test_yaml_blocks_are_valid_documents(page: Path, text: str, tmp_path: Path) -> None:
    name = re.search(r"^name: (\w+)$", text, re.MULTILINE)
    assert name, page
    file = tmp_path / f"{name[1]}.yaml"
    file.write_text(text, encoding="utf-8")
    assert check_document(file) == []


@pytest.mark.parametrize("page", PAGES, ids=[page.name for page in PAGES])
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text("utf-8")):
        assert (page.parent / target).exists(), target
