"""``cb fmt``: files are replaced, checked or shown, and invalid YAML is reported."""

from __future__ import annotations

import io
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.cli.test_main import cb
from tests.conftest import ROOT

UNEVEN = "cbdsl:   1  # version\nkind: program\n\n\nname:  uneven\n"
EVEN = "cbdsl: 1  # version\nkind: program\n\nname: uneven\n"
POSITIONAL = """\
cbdsl: 1
kind: program
name: push
robot: dexter

controllers:
  search: {potential: spring, reference: head.ahead, feedback: head, effector: head}
  track: {potential: spring, reference: [0 deg, 0 deg], feedback: cyclopean.sat_10, effector: head}

actions: [search, track]

policy:
  XX: search
  0X: search
  1X: track
  X0: track
  X-: search

success: [X1]
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "uneven.yaml").write_text(UNEVEN, encoding="utf-8")
    (tmp_path / "even.yaml").write_text(EVEN, encoding="utf-8")
    return tmp_path


def test_files_that_change_are_replaced_and_named(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    before = (here / "even.yaml").stat().st_mtime_ns
    assert cb(monkeypatch, "fmt", ".") == 0
    assert capsys.readouterr().out == "formatted uneven.yaml\n"
    assert (here / "uneven.yaml").read_text("utf-8") == EVEN
    assert (here / "even.yaml").stat().st_mtime_ns == before
    assert cb(monkeypatch, "fmt", ".") == 0
    assert capsys.readouterr().out == ""


def test_check_and_diff_write_nothing(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "fmt", "--check", ".") == 1
    assert cb(monkeypatch, "fmt", "--check", "even.yaml") == 0
    assert capsys.readouterr().out == "would format uneven.yaml\n"
    assert cb(monkeypatch, "fmt", "--diff", ".") == 0
    shown = capsys.readouterr().out
    assert "-name:  uneven\n+name: uneven\n" in shown
    assert (here / "uneven.yaml").read_text("utf-8") == UNEVEN


def test_invalid_yaml_is_reported_and_the_rest_continues(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    bad = "kind: program\na: [1\nb: 2\n"
    (here / "bad.yaml").write_text(bad, encoding="utf-8")
    assert cb(monkeypatch, "fmt", ".") == 1
    shown = capsys.readouterr().out
    assert "bad.yaml:2:4: CB104" in shown and "formatted uneven.yaml" in shown
    assert (here / "bad.yaml").read_text("utf-8") == bad


def test_standard_input_is_printed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(UNEVEN.encode())))
    assert cb(monkeypatch, "fmt", "-") == 0
    assert capsys.readouterr().out == EVEN
    assert cb(monkeypatch, "fmt", "-", "--check") == 2


FOREIGN = {
    "docker-compose.yml": "services:\n    web:\n        image:   nginx\n\n\nvolumes: {}\n",
    ".github/workflows/ci.yml": "on:   push\n",
    ".venv/lib/own.yaml": UNEVEN,
    "node_modules/x/own.yaml": UNEVEN,
    "ignored/own.yaml": UNEVEN,
    "charts/pod.yaml": "apiVersion:   v1\nkind:   Pod\n",
    "charts/helm.yaml": "x:   {{ .Values.x }}\n",
    "programs/values.yaml": "a:   1\n",
    "empty.yaml": "",
}


def test_fmt_of_a_folder_leaves_yaml_of_other_tools_alone(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / ".gitignore").write_text("ignored/\n", encoding="utf-8")
    for name, text in FOREIGN.items():
        (here / name).parent.mkdir(parents=True, exist_ok=True)
        (here / name).write_text(text, encoding="utf-8")
    assert cb(monkeypatch, "fmt", ".") == 0
    assert capsys.readouterr().out == "formatted uneven.yaml\n"
    assert {name: (here / name).read_text("utf-8") for name in FOREIGN} == FOREIGN


def test_fmt_of_a_named_file_of_another_tool_states_the_reason(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = FOREIGN["docker-compose.yml"]
    (here / "compose.yml").write_text(text, encoding="utf-8")
    assert cb(monkeypatch, "fmt", "compose.yml") == 0
    shown = capsys.readouterr()
    assert shown.out == "" and "compose.yml: not formatted" in shown.err
    assert (here / "compose.yml").read_text("utf-8") == text
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(text.encode())))
    assert cb(monkeypatch, "fmt", "-") == 0
    assert capsys.readouterr().out == text


def test_fmt_of_a_decimal_comma_keeps_its_finding(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = "cbdsl: 1\nkind: program\ncontrollers:\n  a: {speed: 1,5 rad/s, gain:  2}\n"
    (here / "comma.yaml").write_text(text, encoding="utf-8")
    assert cb(monkeypatch, "fmt", "comma.yaml") == 0
    assert (here / "comma.yaml").read_text("utf-8") == text


def test_shipped_documents_are_found_by_name(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(ROOT)
    assert cb(monkeypatch, "fmt", "--check", "dexter", "robots", "programs", "knowledge") == 0
    assert capsys.readouterr().out == ""


def test_steps_replace_the_policy_of_programs_only(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "push.yaml").write_text(POSITIONAL, encoding="utf-8")
    (here / "broken.yaml").write_text(
        POSITIONAL.replace("potential", "potentiall"), encoding="utf-8"
    )
    assert cb(monkeypatch, "fmt", "--steps", "push.yaml", "broken.yaml") == 1
    out = capsys.readouterr().out
    assert out.startswith("formatted push.yaml\nbroken.yaml:")
    assert "unknown key 'potentiall'" in out
    text = (here / "push.yaml").read_text("utf-8")
    assert "\nsteps:\n" in text
    assert "\npolicy:" not in text
    assert cb(monkeypatch, "fmt", "--steps", "push.yaml") == 0
    assert capsys.readouterr().out == ""
