"""Distributions built from this checkout, and their use in a bare environment."""

from __future__ import annotations

import json
import subprocess
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

from tests.conftest import ROOT

pytestmark = pytest.mark.slow

PLUGINS = sorted((ROOT / "distributions").glob("cbdsl-*"))
SHIPPED = ("robots", "programs", "knowledge", "schemas")


def made(folder: Path) -> Path:
    """Create a bare environment and return its ``bin``."""
    venv.create(folder, with_pip=True)
    return folder / "bin"


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the wheel and the sdist, the wheel built from the sdist."""
    folder = tmp_path_factory.mktemp("built")
    tools = made(folder / "tools")
    pip = subprocess.run([tools / "pip", "install", "-q", "build"], capture_output=True, text=True)
    if pip.returncode:
        pytest.skip("pip reaches no package index")
    for project in (ROOT, ROOT / "reproduction", *PLUGINS):
        command = [tools / "python", "-m", "build", "-o", folder / "dist", project]
        subprocess.run(command, check=True, capture_output=True)
    return folder / "dist"


def test_wheel_holds_package_types_and_shipped_documents(built: Path) -> None:
    (wheel,) = built.glob("cbdsl-*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    assert {"cbdsl/py.typed", "cbdsl/cli/main.py", "cbdsl/diagnostics/codes/CB1.toml"} <= {*names}
    assert any(name.endswith("licenses/LICENSE") for name in names)
    for folder in SHIPPED:
        tracked = {
            file.relative_to(ROOT) for file in (ROOT / folder).rglob("*.*") if file.is_file()
        }
        tracked = {file for file in tracked if "__pycache__" not in file.parts}
        assert {f"cbdsl/shipped/{file.as_posix()}" for file in tracked} <= {*names}
    assert {name.split("/")[0].split("-")[0] for name in names} == {"cbdsl"}


def test_experiments_are_in_a_wheel_of_their_own(built: Path) -> None:
    (wheel,) = built.glob("cbdsl_reproduction-*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    assert {"cbdsl_reproduction/reproduce.py", "cbdsl_reproduction/causes.toml"} <= {*names}
    assert {name.split("/")[0].split("-")[0] for name in names} == {"cbdsl_reproduction"}
    (bare,) = built.glob("cbdsl-*.whl")
    versions = {file.name.split("-")[1] for file in (wheel, bare)}
    assert len(versions) == 1
    assert not [name for name in zipfile.ZipFile(bare).namelist() if "reproduc" in name]


@pytest.mark.parametrize("plugin", [folder.name for folder in PLUGINS])
def test_plugin_is_in_a_wheel_of_its_own_with_the_version_of_cbdsl(
    built: Path, plugin: str
) -> None:
    name = plugin.replace("-", "_")
    (wheel,), (core,) = built.glob(f"{name}-*.whl"), built.glob("cbdsl-*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    assert {entry.split("/")[0].split("-")[0] for entry in names} == {name}
    assert wheel.name.split("-")[1] == core.name.split("-")[1]
    assert f"{name}/__init__.py" in names and not [entry for entry in names if "test" in entry]


def test_sdist_can_be_tested(built: Path) -> None:
    (sdist,) = built.glob("cbdsl-*.tar.gz")
    with tarfile.open(sdist) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    wanted = {"LICENSE", "README.md", "CHANGELOG.md", "SECURITY.md", "pyproject.toml", "Makefile"}
    assert wanted | {"tests/conftest.py", "docs/documents/robot.md", "robots/dexter.urdf"} <= names
    assert not [name for name in names if name.startswith((".venv", ".git/", "dist/"))]


def test_bare_environment_validates_and_names_the_extra_for_runs(
    built: Path, tmp_path: Path
) -> None:
    (wheel,) = built.glob("cbdsl-*.whl")
    bare, here = made(tmp_path / "bare"), tmp_path / "here"
    here.mkdir()
    subprocess.run([bare / "pip", "install", "-q", wheel], check=True, capture_output=True)

    def cb(*words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([bare / "cb", *words], cwd=here, capture_output=True, text=True)

    assert cb("--version").stdout.startswith("cbdsl ")
    names = {row["name"] for row in json.loads(cb("list", "--json").stdout)}
    assert {"dexter", "reachtouch", "table_right"} <= names
    assert cb("validate", "reachtouch", "dexter").returncode == 0
    assert cb("new", "program", "mine").returncode == 0
    assert cb("validate", ".").returncode == 0
    export = cb("export", "lerobot", "tapes")
    assert export.returncode == 2 and "pip install 'cbdsl[lerobot]'" in export.stderr
    assert export.stderr.count("\n") == 1
    extras = {
        "calibrate": "calibration", "drive": "ros2", "playground": "report", "report": "report",
        "why": "why",
    }  # fmt: skip
    for command, extra in extras.items():
        refused = cb(command, "dexter")
        assert refused.returncode == 2 and refused.stderr.count("\n") == 1
        assert f"pip install 'cbdsl[{extra}]'" in refused.stderr
    (checked,) = json.loads(cb("validate", "dexter", "--format", "json").stdout)["findings"]
    assert (checked["severity"], checked["code"]) == ("note", "CB324")
    assert "pip install 'cbdsl[ros2]'" in checked["message"]
    run = cb("run", "mine")
    assert run.returncode == 2 and "pip install 'cbdsl[sim]'" in run.stderr
    for words in (["explain", "CB101"], ["schema", "program"], ["show", "types"], ["--help"]):
        done = cb(*words)
        assert (done.returncode, done.stderr) == (0, "")
