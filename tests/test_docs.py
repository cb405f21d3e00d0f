"""Every YAML block in the docs is a document without findings, and what they name exists."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.reproduction.registry import EXPERIMENTS

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


@pytest.mark.parametrize("page", PAGES, ids=[page.name for page in PAGES])
def test_files_of_the_project_that_are_named_exist(page: Path) -> None:
    folders = "benchmarks|cbdsl|docs|programs|robots|schemas|tests"
    for name in re.findall(rf"`[^`\n]*?\b((?:{folders})/[\w./-]+)", page.read_text("utf-8")):
        assert (ROOT / name).exists(), name


def test_every_deviation_that_names_a_test_names_one_that_tests() -> None:
    page = (ROOT / "docs" / "deviations.md").read_text("utf-8")
    named = set(re.findall(r"`(tests/[\w/]+\.py)`", page))
    assert len(named) > 20
    for name in named:
        assert re.search(r"^def test_", (ROOT / name).read_text("utf-8"), re.MULTILINE), name


@pytest.mark.parametrize("page", PAGES, ids=[page.name for page in PAGES])
def test_experiments_that_are_named_can_be_reproduced(page: Path) -> None:
    text = page.read_text("utf-8")
    for name in re.findall(r"`((?:fig|table|law)-[\w.-]+)`", text):
        assert name in EXPERIMENTS, name
