"""Ceilings of the packages' sizes, and of their sum."""

from __future__ import annotations

import tomllib
from pathlib import Path

from tests.conftest import ROOT
from tests.size import excess, lowered, read_limits, sizes, text


def test_packages_keep_within_their_ceilings() -> None:
    """Delete, take the lines from another ceiling, or move a part to a distribution."""
    assert excess(sizes(ROOT / "cbdsl"), read_limits()) == {}


def test_ceilings_together_are_at_most_85_000_lines() -> None:
    assert sum(read_limits().values()) <= 85_000


def test_every_package_has_a_ceiling() -> None:
    assert [*read_limits()] == [*sizes(ROOT / "cbdsl")]


def test_sizes_counts_lines_by_subpackage(tmp_path: Path) -> None:
    (tmp_path / "a" / "b").mkdir(parents=True)
    (tmp_path / "one.py").write_text("x\n")
    (tmp_path / "a" / "two.py").write_text("x\ny\n")
    (tmp_path / "a" / "b" / "three.py").write_text("x\n")
    assert sizes(tmp_path) == {".": 1, "a": 3}


def test_excess_names_a_package_beyond_its_ceiling_and_a_new_one() -> None:
    found = excess({"a": 3, "b": 2, "new": 1}, {"a": 2, "b": 2})
    assert found == {"a": "3 lines, at most 2", "new": "1 lines, at most 0"}


def test_lowered_ceilings_fall_to_the_sizes_and_never_rise() -> None:
    limits = lowered({".": 5, "a": 3}, {".": 9, "a": 2, "gone": 4})
    assert limits == {".": 5, "a": 2}
    assert tomllib.loads(text(limits)) == limits
