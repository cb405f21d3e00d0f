"""Commands in README and CONTRIBUTING are accepted."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

from cbdsl.checking.document import check_document
from cbdsl.cli.main import build_app
from tests.cli.test_main import cb
from tests.conftest import ROOT

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]

# In tables a bar between alternatives is escaped.
QUOTED = re.compile(r"`([^`]+)`")
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def blocks(page: Path, language: str) -> list[str]:
    return [body for name, body in BLOCK.findall(page.read_text("utf-8")) if name == language]


def commands(page: Path) -> Iterator[str]:
    """Yield all commands that begin with ``cb``, in code blocks and within sentences."""
    lines = [line for block in blocks(page, "sh") for line in block.splitlines()]
    quoted = QUOTED.findall(BLOCK.sub("", page.read_text("utf-8")))
    for text in (*lines, *quoted):
        for part in re.split(r"&&|;", text.replace("\n", " ")):
            if match := re.match(r"\s*(?:\S*/)?cb\s+(\w.*)", part):
                yield match[1].replace("\\|", "|").strip()


COMMANDS = [
    pytest.param(command, id=f"{page.name}: cb {command}")
    for page in PAGES
    for command in dict.fromkeys(commands(page))
]


@pytest.fixture(scope="module")
def installed() -> Any:
    """Return the command line with all installed plug-ins."""
    return typer.main.get_command(build_app())


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_exists_with_its_options(command: str, installed: Any) -> None:
    words = shlex.split(command)
    for leaf in leaves(installed, words):
        given = {word.split("=")[0] for word in words if word.startswith("--")}
        assert given <= options(leaf)


def leaves(command: Any, words: list[str]) -> Iterator[Any]:
    """Yield the commands that the first words name, where ``a|b`` names two."""
    if not hasattr(command, "commands"):
        yield command
        return
    assert words, f"{command.name} needs a command"
    for name in words[0].split("|"):
        assert name in command.commands, f"there is no command {name}"
        yield from leaves(command.commands[name], words[1:])


def options(command: Any) -> set[str]:
    spellings = ((*each.opts, *each.secondary_opts) for each in command.params)
    return {option for each in spellings for option in each}


def test_test_command_is_one_line_that_runs_pytest() -> None:
    text = (ROOT / "README.md").read_text("utf-8")
    _, _, after = text.partition("<!-- tests -->")
    block = BLOCK.search(after)
    assert block is not None
    language, body = block.groups()
    assert language == "sh"
    (line,) = body.splitlines()
    setup, last = (shlex.split(part) for part in line.split("&&"))
    assert Path(last[0]).name == "pytest"
    # The first word is something that can be run from a fresh checkout.
    assert (ROOT / setup[0]).exists() or "/" not in setup[0]


def test_pages_and_files_that_are_linked_exist() -> None:
    for page in PAGES:
        for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text("utf-8")):
            assert (page.parent / target).exists(), f"{page.name} links to {target}"


@pytest.fixture
def program(tmp_path: Path) -> Path:
    """Write the example program of the README."""
    (text,) = blocks(ROOT / "README.md", "yaml")
    path = tmp_path / "watch.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_program_is_valid(program: Path) -> None:
    assert check_document(program) == []


def test_readme_with_a_type_clash_shows_the_checker_s_error(
    program: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = program.read_text("utf-8")
    clash = text.replace("reference: [0 deg, 0 deg]", "reference: stereo.sat_10")
    assert clash != text
    program.write_text(clash, encoding="utf-8")
    monkeypatch.chdir(program.parent)
    assert cb(monkeypatch, "validate", program.name) == 1
    (shown,) = blocks(ROOT / "README.md", "text")
    assert capsys.readouterr().out.startswith(shown)


@pytest.mark.slow
def test_the_program_runs(program: Path) -> None:
    done = CliRunner().invoke(
        build_app(), ["run", str(program), "--seed", "3", "--context", "in_view"]
    )
    assert done.exit_code == 0, done.output
    assert "Rewarded after" in done.output
