"""Contract tests of a package, and the modules that packages of this project import."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.conftest import ROOT
from tests.test_docs import DOCS, blocks

GROUPS = sorted(
    path.stem.removeprefix("test_") for path in (ROOT / "cbdsl/extend/contract").glob("test_*.py")
)
#: Entries of the package, one of each group.
ENTRIES = (
    "ideal", "echo", "wrist_force_torque", "keep_out", "orbit", "calm", "monte_carlo", "playlist",
    "DEMO100", "tally", "table", "mjcf", "xacro", "dask", "why",
)  # fmt: skip
PUBLIC = re.compile(r"cbdsl(\.api(\.\w+)?|\.extend\.\w+)?|cbdsl_\w+(\.\w+)*")
MODULES = [
    *sorted((ROOT / "tests/plugins/package/demo").glob("*.py")),
    *sorted(
        path for folder in ROOT.glob("distributions/*/cbdsl_*") for path in folder.rglob("*.py")
    ),
]


def private(text: str) -> Iterator[str]:
    """Yield the private modules of cbdsl that a module imports, also for type checkers."""
    for node in ast.walk(ast.parse(text)):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names = [node.module]
        for name in names:
            if name.partition("_")[0].partition(".")[0] == "cbdsl" and not PUBLIC.fullmatch(name):
                yield name


def test_package_passes_the_contract_tests_of_each_group(site: Path) -> None:
    """Run them as a package does, once for all groups."""
    chosen = "-k", " or ".join(ENTRIES)
    run = subprocess.run(
        [sys.executable, "-m", "pytest", "-v", "-n", "0", "-p", "no:cacheprovider", "--pyargs",
         "cbdsl.extend", *chosen],
        env={**os.environ, "PYTHONPATH": str(site)},
        cwd=site,
        capture_output=True,
        text=True,
    )  # fmt: skip
    assert run.returncode == 0, run.stdout
    passed = re.findall(r"test_(\w+)\.py::\S+\[(\S+)\] PASSED", run.stdout)
    assert {group for group, _ in passed} == {*GROUPS}
    assert [name for name in ENTRIES if not any(name in case for _, case in passed)] == []


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_plugin_imports_the_contract_and_the_api_only(path: Path) -> None:
    assert [*private(path.read_text("utf-8"))] == []


@pytest.mark.parametrize("page", sorted(DOCS.rglob("*.md")), ids=lambda path: path.name)
def test_page_shows_imports_of_the_contract_and_the_api_only(page: Path) -> None:
    shown = [each.text for each in blocks(page) if each.language == "python"]
    assert [name for text in shown for name in private(text)] == []


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("from cbdsl.extend.backend import Backend", []),
        ("import cbdsl, cbdsl_ros2.serve", []),
        ("from cbdsl.backends.backend import Backend", ["cbdsl.backends.backend"]),
        ("def late():\n    import cbdsl.cli.main", ["cbdsl.cli.main"]),
        (
            "from cbdsl.api.requests.run_request import RunRequest",
            ["cbdsl.api.requests.run_request"],
        ),
    ],
)
def test_private_finds_modules_that_may_change(text: str, names: list[str]) -> None:
    assert [*private(text)] == names
