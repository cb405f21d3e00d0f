"""The GitHub Action: its steps, run as GitHub runs them, and its description."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from tests.conftest import ROOT

ACTION = yaml.safe_load((ROOT / "action.yml").read_text("utf-8"))
RIGHT = (ROOT / "programs" / "let_go.yaml").read_text("utf-8")
WRONG = RIGHT.replace("robot: dexter", "robot: dextre")


@pytest.fixture
def runner(tmp_path: Path) -> dict[str, str]:
    """Environment of a step; the folder of the installation is a link to this one."""
    temp = tmp_path / "temp"
    (temp / "cbdsl").mkdir(parents=True)
    (temp / "cbdsl" / "bin").symlink_to(Path(sys.executable).parent)
    files = {name: str(temp / name) for name in ("GITHUB_OUTPUT", "GITHUB_STEP_SUMMARY")}
    defaults = {
        f"CB_{name.upper()}": ACTION["inputs"][name]["default"]
        for name in ("paths", "strict", "sarif")
    }
    return {**os.environ, **files, **defaults, "RUNNER_TEMP": str(temp)}


def step(name: str, runner: dict[str, str], folder: Path) -> subprocess.CompletedProcess[str]:
    command = [str(ROOT / ".ci" / "validate"), name]
    return subprocess.run(command, env=runner, cwd=folder, capture_output=True, text=True)


def outputs(runner: dict[str, str]) -> dict[str, str]:
    """Read the file of outputs as GitHub does."""
    text = Path(runner["GITHUB_OUTPUT"]).read_text("utf-8")
    blocks = {}
    for name, end in re.findall(r"(?m)^(\w+)<<(\w+)$", text):
        blocks[name] = text.partition(f"{name}<<{end}\n")[2].partition(f"\n{end}\n")[0]
    return {**dict(re.findall(r"(?m)^(\w+)=(.*)$", text)), **blocks}


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    folder = tmp_path / "checkout"
    (folder / "programs").mkdir(parents=True)
    (folder / "programs" / "let_go.yaml").write_text(RIGHT, "utf-8")
    return folder


def test_action_passes_for_correct_documents(runner: dict[str, str], checkout: Path) -> None:
    done = step("check", runner, checkout)
    assert done.returncode == 0, done.stderr
    assert outputs(runner) == {"errors": "0", "warnings": "0", "sarif": "cbdsl.sarif"}
    assert json.loads((checkout / "cbdsl.sarif").read_text("utf-8"))["version"] == "2.1.0"
    assert "1 documents, 0 errors" in Path(runner["GITHUB_STEP_SUMMARY"]).read_text("utf-8")


def test_action_fails_with_annotations_and_sarif(runner: dict[str, str], checkout: Path) -> None:
    (checkout / "programs" / "wrong one.yaml").write_text(WRONG, "utf-8")
    paths = {
        "CB_PATHS": "programs/let_go.yaml\nprograms/wrong one.yaml\n",
        "CB_SARIF": "a/b c.sarif",
    }
    done = step("check", runner | paths, checkout)
    assert done.returncode == 1
    assert "::error file=programs/wrong one.yaml,line=" in done.stdout
    assert outputs(runner)["errors"] == "1" and outputs(runner)["sarif"] == "a/b c.sarif"
    (run,) = json.loads((checkout / "a" / "b c.sarif").read_text("utf-8"))["runs"]
    uris = {
        each["locations"][0]["physicalLocation"]["artifactLocation"]["uri"]
        for each in run["results"]
    }
    assert uris == {"programs/wrong%20one.yaml"}


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"CB_STRICT": "yes"}, "allowed: true, false"),
        ({"CB_PATHS": "nowhere"}, "nowhere"),
        ({"CB_PATHS": "$(touch here); `touch here`"}, "touch here"),
    ],
)
def test_action_with_wrong_inputs_says_so_and_writes_nothing(
    changed: dict[str, str], told: str, runner: dict[str, str], checkout: Path
) -> None:
    done = step("check", runner | changed, checkout)
    assert done.returncode == 2 and told in done.stdout + done.stderr
    assert [path.name for path in checkout.iterdir()] == ["programs"]


def test_install_keeps_a_restored_environment(runner: dict[str, str], checkout: Path) -> None:
    done = step("install", runner, checkout)
    assert done.returncode == 0 and re.search(r"\d+\.\d+\.\d+", done.stdout)


def test_cache_key_changes_with_the_installed_files(runner: dict[str, str], tmp_path: Path) -> None:
    root, keys = tmp_path / "action", []
    for name in ("cbdsl", "robots", "programs", "knowledge", "schemas", ".ci"):
        (root / name).mkdir(parents=True)
    shutil.copy(ROOT / ".ci" / "validate", root / ".ci")
    for name in ("hatch_build.py", "pyproject.toml", "constraints.txt"):
        shutil.copy(ROOT / name, root)
    for content in ("1", "2", "1"):
        (root / "cbdsl" / "code.py").write_text(content, "utf-8")
        Path(runner["GITHUB_OUTPUT"]).unlink(missing_ok=True)
        subprocess.run([root / ".ci" / "validate", "key"], env=runner, check=True)
        keys.append(outputs(runner)["key"])
    assert keys[0] == keys[2] != keys[1]


def test_action_names_other_actions_by_digest_and_never_expands_inputs_in_scripts() -> None:
    steps: list[dict[str, Any]] = ACTION["runs"]["steps"]
    for each in steps:
        assert re.fullmatch(r"[\w./-]+@[0-9a-f]{40}", each.get("uses", f"x@{'0' * 40}"))
        assert "${{" not in each.get("run", "")
