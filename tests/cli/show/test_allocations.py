"""Tests of ``cb show allocations``."""

from __future__ import annotations

import json
from collections.abc import Callable

import pytest

from tests.cli.test_main import cb

Shown = Callable[..., str]


@pytest.fixture
def shown(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Shown:
    def run(*words: str) -> str:
        assert cb(monkeypatch, "show", "allocations", *words) == 0
        return capsys.readouterr().out

    return run


def test_suitable_allocations_come_first_and_others_have_reasons(shown: Shown) -> None:
    rows = json.loads(shown("reachtouch", "--json"))
    fits = [row["fits"] for row in rows]
    assert sum(fits) == 3 and fits == sorted(fits, reverse=True) and not all(fits)
    assert all((row["refusal"] is None) == row["fits"] for row in rows)
    text = shown("reachtouch")
    assert text.index("yes") < text.index("is not mounted on 'left_arm'")


def test_program_without_open_resources_is_reported(shown: Shown) -> None:
    assert "lets no parameter stand for another resource" in shown("posture")
