"""Generic tests of the project, run where the package of this folder is installed."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from tests.conftest import ROOT


def run_generic(tests: str, name: str, site: Path) -> None:
    """Run those of a file's tests whose parameters have a name; there has to be one."""
    run = subprocess.run(
        [sys.executable, "-m", "pytest", "-n", "0", f"tests/{tests}", "-k", name],
        env={**os.environ, "PYTHONPATH": str(site)},
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stdout  # it is 5 where no test is selected
