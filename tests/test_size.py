"""Size of the package: the docs state it."""

from __future__ import annotations

import re

from tests.conftest import ROOT


def test_documented_number_of_lines_is_the_current_one() -> None:
    page = (ROOT / "docs" / "concepts.md").read_text("utf-8")
    (stated,) = re.findall(r"`cbdsl` has about ([\d,]+) lines", page)
    files = (ROOT / "cbdsl").rglob("*.py")
    lines = sum(file.read_text("utf-8").count("\n") for file in files)
    # Edit the page after a change of more than 3 %.
    assert abs(lines - int(stated.replace(",", ""))) < 0.03 * lines
