"""Addresses of a release agree in its README, its metadata, its messages and its site."""

from __future__ import annotations

import json
import os
import re
import runpy
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml

from cbdsl.diagnostics import published
from cbdsl.diagnostics.catalogue import catalogue
from cbdsl.diagnostics.entry_text import explanation
from tests.conftest import ROOT

REPOSITORY = "someone/cbdsl"
SITE = "https://someone.github.io/cbdsl/"
DOCUMENTATION = f"{SITE}0.1.0/"


def built(**other: str) -> dict[str, object]:
    """Return the metadata that a build states."""
    command = (sys.executable, "-m", "hatchling", "metadata")
    plain = {name: value for name, value in os.environ.items() if name != "CBDSL_REPOSITORY"}
    done = subprocess.run(command, cwd=ROOT, env=plain | other, capture_output=True, check=True)
    metadata: dict[str, object] = json.loads(done.stdout)
    return metadata


@pytest.fixture
def release(tmp_path: Path) -> Path:
    """Return a folder with the metadata of an installed release."""
    folder = tmp_path / "release" / "cbdsl-0.1.0.dist-info"
    folder.mkdir(parents=True)
    urls = built(CBDSL_REPOSITORY=REPOSITORY)["urls"]
    assert isinstance(urls, dict)
    lines = [f"Project-URL: {label}, {address}\n" for label, address in urls.items()]
    head = "Metadata-Version: 2.4\nName: cbdsl\nVersion: 0.1.0\n"
    (folder / "METADATA").write_text(head + "".join(lines), "utf-8")
    return folder.parent


@pytest.fixture
def installed(release: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    published.published.cache_clear()
    monkeypatch.syspath_prepend(str(release))
    yield
    published.published.cache_clear()


def test_build_without_a_repository_states_no_address() -> None:
    metadata = built()
    assert "urls" not in metadata
    assert str(metadata["readme"]) == str(
        {"content-type": "text/markdown", "text": (ROOT / "README.md").read_text("utf-8")}
    )


def test_readme_of_a_release_links_to_its_documentation_and_its_tag() -> None:
    metadata = built(CBDSL_REPOSITORY=REPOSITORY)
    links = re.findall(r"\]\(([^)]+)\)", str(metadata["readme"]))
    allowed = (DOCUMENTATION, f"https://github.com/{REPOSITORY}/blob/v0.1.0/")
    assert all(link.startswith((*allowed, "https://img.shields.io/")) for link in links)
    for link in links:
        if link.startswith(DOCUMENTATION):
            page = link.removeprefix(DOCUMENTATION).partition("#")[0].replace(".html", ".md")
            assert (ROOT / "docs" / page).exists(), link


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize("code", ["CB101", "CB504"])
def test_messages_link_to_the_documentation_of_a_release(code: str) -> None:
    page = f"{DOCUMENTATION}diagnostics.html#{code.lower()}"
    assert explanation(catalogue()[code]).endswith(f"\n\n{page}")
    hooks = runpy.run_path(str(ROOT / "docs" / "site_hooks.py"))
    written = hooks["on_page_markdown"]("<!-- generated: diagnostics -->")
    assert re.search(rf"(?m)^## {code}: .* {{#{page.partition('#')[2]}}}$", written)


@pytest.mark.usefixtures("installed")
def test_code_of_another_distribution_has_no_page() -> None:
    assert published.page_of("NET101") is None


def test_message_of_a_copy_names_no_address() -> None:
    assert published.page_of("CB504") is None


def test_releases_and_documentation_are_published_from_one_repository() -> None:
    for name in ("release", "docs"):
        workflow = yaml.safe_load((ROOT / f".github/workflows/{name}.yml").read_text("utf-8"))
        build = workflow["jobs"]["build"]
        places = [build.get("env", {}), *(step.get("env", {}) for step in build["steps"])]
        named = [each["CBDSL_REPOSITORY"] for each in places if "CBDSL_REPOSITORY" in each]
        assert named == ["${{ github.repository }}"]


@pytest.mark.slow
def test_versions_of_the_site_have_a_list_a_default_and_their_addresses(
    release: Path, tmp_path: Path
) -> None:
    clone = tmp_path / "clone"
    subprocess.run(["git", "clone", "--quiet", ROOT, clone], check=True)
    person = {
        f"GIT_{who}_{what}": "x" for who in ("AUTHOR", "COMMITTER") for what in ("NAME", "EMAIL")
    }
    env = {
        **os.environ,
        **person,
        "PYTHONPATH": str(release),
        "MAKEFLAGS": "",
        "NO_MKDOCS_2_WARNING": "1",
    }
    # Replays and the playground come from registries, and their scripts are tried elsewhere.
    for script in ("make_gallery.py", "make_playground.py"):
        (clone / "docs" / script).write_text("", "utf-8")
    # One page shows the addresses of all, and its links to others lead nowhere now.
    for written in (clone / "docs").rglob("*.md"):
        if written.name not in ("index.md", "diagnostics.md"):
            written.unlink()
    settings = (clone / "mkdocs.yml").read_text("utf-8")
    settings = re.sub(r"(?ms)^nav:\n.*", "nav: [index.md, diagnostics.md]\n", settings)
    (clone / "mkdocs.yml").write_text(settings.replace("strict: true", "strict: false"), "utf-8")
    make = ("make", f"PYTHON={sys.executable}", "site-version")
    for words in ((), ("VERSION=0.1.0", "ALIAS=latest"), ()):
        subprocess.run([*make, *words], cwd=clone, env=env, check=True, capture_output=True)

    def shown(path: str) -> str:
        command = ["git", "show", f"gh-pages:{path}"]
        return subprocess.run(command, cwd=clone, check=True, capture_output=True, text=True).stdout

    versions = {each["version"]: each["aliases"] for each in json.loads(shown("versions.json"))}
    assert versions == {"dev": [], "0.1.0": ["latest"]}
    assert shown("latest") == "0.1.0"  # a symbolic link
    assert "url=latest/" in shown("index.html")
    page = shown("0.1.0/diagnostics.html")
    assert f'<link rel="canonical" href="{DOCUMENTATION}diagnostics.html">' in page
    assert '<h2 id="cb504">' in page
