"""Files for hosts and tools state the same versions as the project."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Iterator
from datetime import datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.conftest import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
REPRODUCTION = tomllib.loads((ROOT / "reproduction/pyproject.toml").read_text("utf-8"))["project"]
BUILDS = {
    file.parent.name: tomllib.loads(file.read_text("utf-8"))
    for file in (ROOT / "pyproject.toml", *sorted(ROOT.glob("distributions/*/pyproject.toml")))
}
PLUGINS = {name: each["project"] for name, each in BUILDS.items() if name != ROOT.name}
PREFIX = "Programming Language :: Python :: 3."
VERSIONS = sorted(
    (each.split(" :: ")[-1] for each in PROJECT["classifiers"] if each.startswith(PREFIX)),
    key=lambda version: int(version.split(".")[1]),
)
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))


def read(path: Path) -> Any:
    return yaml.safe_load(path.read_text("utf-8"))


def test_workflow_tests_every_stated_python() -> None:
    matrix = read(ROOT / ".github/workflows/tests.yml")["jobs"]["fast"]["strategy"]["matrix"]
    assert matrix["python"] == VERSIONS


def test_setup_and_ci_name_every_stated_python() -> None:
    assert f"for version in {' '.join(reversed(VERSIONS))}; do" in (ROOT / ".ci/run").read_text(
        "utf-8"
    )
    setup = (ROOT / "setup.sh").read_text("utf-8")
    lowest, highest = (f"({each.replace('.', ', ')})" for each in (VERSIONS[0], VERSIONS[-1]))
    assert f"{lowest} <= sys.version_info[:2] <= {highest}" in setup
    assert all(f"python{each}" in setup for each in VERSIONS)


def test_tests_of_other_pythons_in_ci_exist() -> None:
    named = re.findall(r"(?m)\btests(?:/\w+)+(?:\.py)?", (ROOT / ".ci/run").read_text("utf-8"))
    assert len(named) > 15 and all((ROOT / each).exists() for each in named)


@pytest.mark.parametrize("workflow", WORKFLOWS, ids=lambda path: path.stem)
def test_workflow_has_least_permissions_and_bounded_jobs(workflow: Path) -> None:
    content = read(workflow)
    assert content["permissions"] == {"contents": "read"}
    for job in content["jobs"].values():
        if "uses" in job:
            assert job["uses"].startswith("./.github/workflows/")
            continue
        granted = job.get("permissions", {})
        assert "timeout-minutes" in job or "id-token" in granted
        assert "id-token" not in granted or "environment" in job


@pytest.mark.parametrize("workflow", WORKFLOWS, ids=lambda path: path.stem)
def test_workflow_names_actions_of_others_by_digest(workflow: Path) -> None:
    steps = [step for job in read(workflow)["jobs"].values() for step in job.get("steps", ())]
    used = [step["uses"] for step in steps if "uses" in step]
    for action in used:
        assert re.fullmatch(r"[\w./-]+@[0-9a-f]{40}|docker://[\w./-]+@sha256:[0-9a-f]{64}", action)


def test_release_publishes_only_tested_files_with_their_digests() -> None:
    jobs = read(ROOT / ".github/workflows/release.yml")["jobs"]
    (publish,) = [job for job in jobs.values() if "id-token" in job.get("permissions", {})]
    assert set(publish["needs"]) == {"tests", "build"}
    download, check, upload = publish["steps"]
    assert download["uses"].startswith("actions/download-artifact@")
    assert check["run"].endswith("sha256sum --check --strict")
    assert upload["uses"].startswith("pypa/gh-action-pypi-publish@")


def test_published_files_are_built_by_tools_with_digests() -> None:
    build = next(
        rule for rule in (ROOT / "Makefile").read_text("utf-8").split("\n\n") if "\ndist:\n" in rule
    )
    assert "--require-hashes -r .ci/build-requirements.txt" in build
    assert "-m build --no-isolation" in build
    listed = (ROOT / ".ci/build-requirements.txt").read_text("utf-8")
    pinned = re.findall(r"(?m)^([\w-]+)==\S+[^\n]*\\\n    --hash=sha256:[0-9a-f]{64}", listed)
    for project in BUILDS.values():
        names = {Requirement(each).name for each in project["build-system"]["requires"]}
        assert names <= set(pinned)


def test_metadata_of_archives_and_packages_has_the_version_and_the_title() -> None:
    citation = read(ROOT / "CITATION.cff")
    archives = [
        json.loads((ROOT / name).read_text("utf-8")) for name in ("codemeta.json", ".zenodo.json")
    ]
    assert {each["version"] for each in archives} == {PROJECT["version"]}
    assert archives[1]["title"] == citation["title"]
    assert all(sorted(each["keywords"]) == sorted(citation["keywords"]) for each in archives)
    recipe = (ROOT / "packaging/conda/recipe.yaml").read_text("utf-8")
    assert f'version: "{PROJECT["version"]}"' in recipe
    for folder in (ROOT / "distributions/cbdsl-ros2/ros").iterdir():
        manifest = (folder / "package.xml").read_text("utf-8")
        assert f"<version>{PROJECT['version']}</version>" in manifest


def bounds(requirement: Requirement) -> str:
    """Return the versions of a requirement, lowest first."""
    return ",".join(sorted(map(str, requirement.specifier), reverse=True))


def test_conda_recipe_has_the_requirements_of_the_kinematic_engine() -> None:
    recipe = read(ROOT / "packaging/conda/recipe.yaml")
    names = {"pin": "pinocchio", "opencv-python-headless": "py-opencv"}
    wanted = {
        f"{names.get(each.name, each.name)} {bounds(each)}"
        for each in map(Requirement, [*PROJECT["dependencies"], *EXTRAS["kinematic"]])
    }
    given = {each for each in recipe["requirements"]["run"] if not each.startswith("python ")}
    assert given == wanted - {"cbdsl"}


def test_paper_has_the_sections_and_length_of_its_journal_and_cites_its_bibliography() -> None:
    paper = (ROOT / "docs/paper/paper.md").read_text("utf-8")
    _, head, body = paper.split("---\n", 2)
    about = yaml.safe_load(head)
    assert {"title", "tags", "authors", "affiliations", "date", "bibliography"} <= set(about)
    assert re.findall(r"(?m)^# (.+)$", body) == [
        "Summary", "Statement of need", "State of the field", "Software design",
        "Research impact statement", "Acknowledgements", "References",
    ]  # fmt: skip
    institutions = {each["index"] for each in about["affiliations"]}
    assert all(each["affiliation"] in institutions for each in about["authors"])
    assert datetime.strptime(about["date"], "%d %B %Y").year >= 2026
    assert 750 <= len(body.split()) <= 1750
    listed = (ROOT / "docs/paper" / about["bibliography"]).read_text("utf-8")
    assert {*re.findall(r"\[@(\w+)\]", body)} == {*re.findall(r"(?m)^@\w+\{(\w+),", listed)}
    # A reader can find each work: by an address, or by its school or its pages in print.
    for entry in listed.split("\n}\n"):
        given = set(re.findall(r"(?m)^  (\w+) = ", entry))
        assert not given or given & {"doi", "url", "school"} or {"volume", "pages"} <= given, entry


def test_citation_has_the_version_of_all_distributions() -> None:
    assert read(ROOT / "CITATION.cff")["version"] == PROJECT["version"] == version("cbdsl")
    assert {version(name) for name in ("cbdsl-reproduction", *PLUGINS)} == {PROJECT["version"]}


@pytest.mark.parametrize("name", PLUGINS)
def test_plugin_is_an_extra_that_setup_and_ci_install(name: str) -> None:
    assert PLUGINS[name]["name"] == name
    assert EXTRAS[name.removeprefix("cbdsl-")] == [name]
    assert PLUGINS[name]["requires-python"] == PROJECT["requires-python"]
    assert f"-e distributions/{name}" in (ROOT / ".ci/run").read_text("utf-8")


def test_experiments_are_in_a_distribution_of_their_own() -> None:
    assert REPRODUCTION["requires-python"] == PROJECT["requires-python"]
    assert not list((ROOT / "cbdsl").rglob("reproduction"))
    assert {"matplotlib", "scipy"} <= {Requirement(d).name for d in REPRODUCTION["dependencies"]}


def required(extras: Iterable[str], python: str) -> Iterator[Requirement]:
    """Yield requirements of extras on a version of Python, with nested extras."""
    place = {
        "python_version": python, "python_full_version": f"{python}.9", "sys_platform": "linux",
        "platform_machine": "x86_64",
    }  # fmt: skip
    texts = [*PROJECT["dependencies"], *(text for extra in extras for text in EXTRAS[extra])]
    for requirement in map(Requirement, texts):
        if requirement.marker is not None and not requirement.marker.evaluate(place):
            continue
        if requirement.name == "cbdsl":
            yield from required(requirement.extras, python)
        else:
            yield requirement


@pytest.mark.parametrize("python", VERSIONS)
def test_constraints_hold_every_requirement_of_developers(python: str) -> None:
    place = {"python_full_version": f"{python}.9", "python_version": python}
    lines = (ROOT / "constraints.txt").read_text("utf-8").splitlines()
    pinned = {}
    for line in lines:
        if line and not line.startswith("#"):
            constraint = Requirement(line)
            if constraint.marker is None or constraint.marker.evaluate(place):
                (specifier,) = constraint.specifier
                pinned[canonicalize_name(constraint.name)] = specifier.version
    texts = [*REPRODUCTION["dependencies"], *REPRODUCTION["optional-dependencies"]["dev"]]
    texts += [text for plugin in PLUGINS.values() for text in plugin["dependencies"]]
    own = [
        each
        for each in map(Requirement, texts)
        if each.name != "cbdsl" and (each.marker is None or each.marker.evaluate(place))
    ]
    for requirement in [*required(["dev"], python), *own]:
        name = canonicalize_name(requirement.name)
        assert name in pinned, f"make constraints: {name} is not in constraints.txt"
        assert requirement.specifier.contains(pinned[name]), f"make constraints: {name}"


def test_pre_commit_hooks_run_commands_of_the_checks() -> None:
    (repository,) = read(ROOT / ".pre-commit-config.yaml")["repos"]
    checks = (ROOT / "Makefile").read_text("utf-8")
    for hook in repository["hooks"]:
        command = re.sub(r"^\.venv/bin/", "", hook["entry"])
        assert f"$(BIN){command}" in checks, hook["id"]


def test_spelling_leaves_out_skipped_files_that_a_hook_names() -> None:
    folders = (
        ROOT / "tests/fuzz/corpus",
        ROOT / "tests/checking/bad",
        ROOT / "cbdsl/diagnostics/codes",
    )
    named = [file for folder in folders for file in folder.iterdir() if file.is_file()]
    names = [str(file.relative_to(ROOT)) for file in named]
    command = [sys.executable, "-m", "codespell_lib", *names]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "")
