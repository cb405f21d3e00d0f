"""Arguments of a call: empty ones are refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.test_main import cb


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["validate", ""], "after 'validate'"),
        (["run", "reach", "--record", ""], "--record is"),
        (["run", "reach", "--record="], "--record is"),
        (["run", "reach", "--stage", "", "--seed", "1"], "--stage is"),
        (["learn", "reach", "--out", ""], "--out is"),
        (["new", "program", ""], "after 'program'"),
    ],
)
def test_empty_word_is_one_clear_message_and_nothing_is_done(
    words: list[str],
    told: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cb(monkeypatch, *words) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and printed.err.count("\n") == 1
    assert told in printed.err and "empty" in printed.err
    assert not list(tmp_path.iterdir())


def test_word_with_a_trailing_equals_sign_is_no_empty_option(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "validate", "--with", "arm=", "reach") == 2
    assert "--with arm=: expected name=value" in capsys.readouterr().err
