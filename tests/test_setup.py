"""Refusals of setup.sh, each in one sentence and before anything is installed."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.conftest import ROOT


def refusal(folder: Path, *words: str, **variables: str) -> str:
    """Return the message with which setup.sh ends in a copy of its files."""
    for name in ("setup.sh", "pyproject.toml"):
        shutil.copy(ROOT / name, folder)
    command = ["sh", str(folder / "setup.sh"), *words]
    environment = {**os.environ, **variables}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, cwd="/")
    assert (done.returncode, done.stdout) == (1, "")
    assert not (folder / ".venv").exists()
    return done.stderr


@pytest.mark.parametrize("version", ["(2, 7)", "(3, 10)", "(3, 15)"])
def test_setup_with_an_unsupported_python_names_the_supported_ones(
    tmp_path: Path, version: str
) -> None:
    python = tmp_path / "python"
    lines = ("#!/bin/sh", f'exec python3 -c "import sys; sys.version_info = {version}; $2"')
    python.write_text("\n".join(lines), encoding="utf-8")
    python.chmod(0o755)
    script = tmp_path / "setup.sh"
    assert refusal(tmp_path, "sim", PYTHON=str(python)) == (
        f"setup: no supported Python in '{python}': install 3.11 to 3.14, "
        f"or name one: PYTHON=/path/to/python {script} sim\n"
    )


@pytest.mark.parametrize("extras", ["simm", "sim,simm"])
def test_setup_with_an_unknown_extra_names_the_extras(tmp_path: Path, extras: str) -> None:
    message = refusal(tmp_path, extras)
    assert message.startswith("setup: unknown extra 'simm'; allowed: kinematic bullet mujoco sim ")
    assert message.count("\n") == 1
