"""Seeds that judge occur nowhere where something is chosen; see docs/seeds.md."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.conftest import ROOT

JUDGING = range(7_000_000, 8_000_000)
#: Seeds of docs/results.md, derived from digests of the judged code.
DERIVED = range(70_000_000, 80_000_000)
FOLDERS = (
    "benchmarks", "cbdsl", "distributions", "knowledge", "programs", "reproduction", "robots",
    "tests",
)  # fmt: skip
NUMBER = re.compile(r"(?<![\w.])\d[\d_]{6,}(?![\w.])")


def numbers(text: str) -> Iterator[int]:
    """Yield whole numbers of seven digits or more in a text."""
    return (int(each.replace("_", "")) for each in NUMBER.findall(text))


def files(folder: str) -> list[Path]:
    found = (ROOT / folder).rglob("*")
    return [path for path in found if path.suffix in {".py", ".yaml"}]


@pytest.mark.parametrize("folder", FOLDERS)
def test_judging_seeds_occur_nowhere_else(folder: str) -> None:
    guilty = {
        str(path.relative_to(ROOT)): number
        for path in files(folder)
        if path != Path(__file__)
        for number in numbers(path.read_text("utf-8", errors="replace"))
        if number in JUDGING or number in DERIVED
    }
    assert guilty == {}


def test_numbers_are_read_in_every_notation() -> None:
    assert list(numbers("seed=7_000_001, range(7000002), x7000003, 7000004.5")) == [
        7_000_001,
        7_000_002,
    ]


def test_page_names_the_range() -> None:
    text = (ROOT / "docs" / "seeds.md").read_text("utf-8")
    for seeds in (JUDGING, DERIVED):
        assert f"{seeds.start} to {seeds.stop - 1}" in text
