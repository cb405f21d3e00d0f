"""Tests of ``cb show substitutes``."""

from __future__ import annotations

import json

import pytest

from tests.cli.test_main import cb


def test_show_substitutes_lists_programs_of_the_same_reward(
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


def test_unrewarded_program_has_no_substitutes(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "show", "substitutes", "posture") == 0
    assert "no program has a rewarded kind in common with posture" in capsys.readouterr().out
