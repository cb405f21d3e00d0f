"""Formats of ``cb show`` and ``cb list``: one option prints every table as JSON."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cbdsl.cli.show.show import show
from tests.cli.test_main import cb

WEDGE = Path("cbdsl/diagnostics/codes/wedge.obj").resolve()

#: Arguments of each command of ``cb show``.
ASKED = {
    "types": [],
    "potentials": [],
    "resources": ["--robot", "sixaxis"],
    "sources": [],
    "drivers": [],
    "modifiers": [],
    "learners": [],
    "kinds": [],
    "backends": [],
    "program": ["reachtouch"],
    "allocations": ["twist"],
    "bindings": ["poise"],
    "substitutes": ["searchtrack"],
    "policy": ["searchtrack"],
    "mesh": [str(WEDGE)],
    "schema": ["pick_and_place"],
    "catalog": ["red_ball"],
    "meta-catalog": ["four_things"],
    "relations": ["contacts"],
    "shared": ["looking"],
    "knowledge": [],
}


def test_every_show_command_is_tested() -> None:
    assert {command.name for command in show.registered_commands} == set(ASKED)


@pytest.mark.parametrize("name", ASKED)
def test_json_is_printed_by_either_option(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["show", name, *ASKED[name]]
    assert not cb(monkeypatch, *words, "--format", "json")
    by_format = capsys.readouterr().out
    assert not cb(monkeypatch, *words, "--json")
    assert json.loads(by_format) == json.loads(capsys.readouterr().out)
    assert not cb(monkeypatch, *words, "--format", "text")
    with pytest.raises(json.JSONDecodeError):
        json.loads(capsys.readouterr().out)


@pytest.mark.parametrize("name", ASKED)
def test_another_format_is_refused_with_the_nearest(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "show", name, *ASKED[name], "--format", "jsn") == 2
    assert "did you mean 'json'? (known: text, json" in capsys.readouterr().err


def test_list_of_documents_has_the_same_option(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert not cb(monkeypatch, "list", "robots", "--format", "json")
    assert {row["kind"] for row in json.loads(capsys.readouterr().out)} == {"robot"}


@pytest.mark.parametrize("command", ["run", "learn", "explore", "calibrate"])
def test_backend_option_with_help_lists_the_backends(
    command: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert not cb(monkeypatch, command, "x", "--backend", "--help")
    listed = capsys.readouterr().out
    assert all(name in listed for name in ("bullet", "mujoco", "kinematic"))


def test_backend_without_a_name_lists_the_known_ones(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "run", "reach", "--backend") == 2
    assert "--backend is given no name (known: bullet, " in capsys.readouterr().err


def test_program_data_has_the_automaton_of_a_program(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "show", "program", "take", "--json") == 0
    automaton = json.loads(capsys.readouterr().out)["automaton"]
    assert automaton["start"] == "survey"
    survey = next(step for step in automaton["steps"] if step["step"] == "survey")
    failed = {"when": "survey failed", "to": "fail", "letters": {"survey": "-"}}
    assert failed in survey["exits"]
    assert cb(monkeypatch, "show", "program", "take") == 0
    assert "    survey failed: fail\n" in capsys.readouterr().out
