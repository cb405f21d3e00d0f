"""Descriptions of ``cb validate`` for other tools: they agree with its behaviour."""

from __future__ import annotations

import json
import re

import pytest
import yaml

from cbdsl.cli.commands import COMMANDS
from cbdsl.yaml_text.library import shipped
from tests.cli.test_main import BAD, ROOT, cb

PAGE = (ROOT / "docs" / "ci.md").read_text("utf-8")


def test_pre_commit_hook_takes_the_shipped_documents_and_no_others() -> None:
    (hook,) = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text("utf-8"))
    program, command = hook["entry"].split()
    assert program == "cb" and command in COMMANDS
    documents = [p for folder in ("robots", "programs") for p in (ROOT / folder).rglob("*.yaml")]
    assert documents
    for path in documents:
        assert re.search(hook["files"], path.relative_to(ROOT).as_posix())
    for other in ("pyproject.toml", "robots/dexter.urdf", ".pre-commit-hooks.yaml", "mkdocs.yml"):
        assert not re.search(hook["files"], other)


@pytest.mark.parametrize(
    ("name", "owner"), [("type_clash", "cb-error"), ("unused_controller", "cb-warning")]
)
def test_problem_matcher_finds_places(
    name: str, owner: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    block = re.search(r"```json\n(.*?)```", PAGE, re.DOTALL)
    assert block
    matchers = json.loads(block[1])["problemMatcher"]
    path = BAD / "programs" / f"{name}.yaml"
    cb(monkeypatch, "validate", str(path))
    text = capsys.readouterr().out
    found = {
        matcher["owner"]: re.findall(matcher["pattern"][0]["regexp"], text, re.MULTILINE)
        for matcher in matchers
    }
    assert [owner for owner, matches in found.items() if matches] == [owner]
    ((file, *_),) = found[owner]
    assert file == str(path)


def test_workflows_on_the_page_are_yaml_with_valid_commands() -> None:
    blocks = re.findall(r"^```yml\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
    assert len(blocks) == 3
    for block in blocks:
        assert yaml.safe_load(block)
    assert (shipped() / "robots").is_dir() and (shipped() / "programs").is_dir()
