"""Tests of ``cb show substitutes``."""

from __future__ import annotations

import json

import pytest

from tests.cli.test_main import cb


def test_what_stands_in_for_what(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "show", "substitutes", "reachtouch", "--json") == 0
    rows = json.loads(capsys.readouterr().out)
    wanted = {
        "in place of": "touch",
        "program": "tactileprobe",
        "rewarded for": "spring of force, by configuration",
    }
    assert wanted in rows
    assert cb(monkeypatch, "show", "substitutes", "reachtouch") == 0
    assert "tactileprobe" in capsys.readouterr().out


def test_nothing_substitutes_an_unrewarded_program(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "show", "substitutes", "posture") == 0
    assert "no program is rewarded for what posture" in capsys.readouterr().out
