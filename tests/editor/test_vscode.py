"""The extension for VS Code: built, activated against ``cb lsp`` and packaged."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tests.conftest import ROOT

pytestmark = pytest.mark.slow
EXTENSION = ROOT / "editors" / "vscode"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Copy the extension, and install the packages of its build."""
    if shutil.which("npm") is None:
        pytest.skip("npm is not installed")
    folder = tmp_path_factory.mktemp("vscode") / "extension"
    shutil.copytree(EXTENSION, folder, ignore=shutil.ignore_patterns("node_modules", "out"))
    done = subprocess.run(["npm", "ci"], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        pytest.skip("npm reaches no registry")
    return folder


def test_extension_activates_and_reports_diagnostics(folder: Path) -> None:
    pytest.importorskip("pygls")
    given = {"CB": str(Path(sys.executable).with_name("cb")), "CBDSL": str(ROOT)}
    done = subprocess.run(
        ["npm", "test"], cwd=folder, capture_output=True, text=True, env={**os.environ, **given}
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "# fail 0" in done.stdout and "# pass 3" in done.stdout


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"CB": "/nowhere/cb"}, "'/nowhere/cb' does not start (ENOENT): CB=/path/to/cb npm test"),
        ({"CBDSL": "/nowhere"}, "'/nowhere' is not the folder of the project: CBDSL="),
    ],
)
def test_missing_test_dependency_is_reported(
    given: dict[str, str], told: str, folder: Path
) -> None:
    sound = {"CB": str(Path(sys.executable).with_name("cb")), "CBDSL": str(ROOT)}
    env = {**os.environ, **sound, **given}
    done = subprocess.run(["npm", "test"], cwd=folder, capture_output=True, text=True, env=env)
    assert done.returncode != 0 and told in done.stdout + done.stderr


def test_extension_package_contains_only_required_files(folder: Path) -> None:
    done = subprocess.run(["npm", "run", "package"], cwd=folder, capture_output=True, text=True)
    if "E404" in done.stderr or "ENOTFOUND" in done.stderr:
        pytest.skip("npm reaches no registry")
    assert done.returncode == 0, done.stdout + done.stderr
    with zipfile.ZipFile(folder / "cbdsl.vsix") as package:
        names = {name for name in package.namelist() if name.startswith("extension/")}
        manifest = json.loads(package.read("extension/package.json"))
    assert {name.lower() for name in names} == {
        "extension/package.json", "extension/readme.md", "extension/license.txt",
        "extension/out/extension.js",
    }  # fmt: skip
    assert manifest["main"] == "./out/extension.js"
