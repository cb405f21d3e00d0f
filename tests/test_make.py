"""The checks run each test once: the README's test command the fast ones, CI then the slow ones."""

from __future__ import annotations

import shutil
import subprocess

import pytest

from tests.conftest import ROOT
from tests.test_readme import blocks

pytestmark = pytest.mark.skipif(shutil.which("make") is None, reason="needs make")


def planned_tests(*arguments: str) -> str:
    """Return the pytest command that ``make`` would run."""
    planned = subprocess.run(
        ["make", "--dry-run", *arguments], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return next(line for line in planned.stdout.splitlines() if "pytest" in line)


def test_developer_runs_all_tests() -> None:
    assert planned_tests("check").endswith('-m "slow or not slow"')


def test_ci_runs_fast_tests_by_the_readme_and_slow_ones_by_make() -> None:
    first = [line for line in blocks(ROOT / "README.md", "sh") if "pytest" in line]
    assert len(first) == 1 and " -m" not in first[0]  # as pyproject.toml has it: not slow
    lines = (ROOT / ".ci" / "run").read_text("utf-8").splitlines()
    (slow,) = [line for line in lines if line.startswith("make tests")]
    assert planned_tests(*slow.split()[1:]).endswith('-m "slow"')
