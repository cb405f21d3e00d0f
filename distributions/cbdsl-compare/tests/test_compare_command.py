"""``cb compare``: counts, interval, the first difference and its cause."""

from __future__ import annotations

import json

import pytest

from tests.cli.test_main import cb

_SIDES = ("searchtrack,backend=kinematic", "searchtrack,backend=kinematic,stage=absent")


def test_compare_as_json_explains_the_first_difference(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "compare", *_SIDES, "--seeds", "0-1", "--all", "--json") == 0
    row = json.loads(capsys.readouterr().out)
    assert (row["seeds"], row["successes"], row["alone"]) == ([0, 1], [2, 0], [2, 0])
    assert row["interval"][0] == row["difference"] == -1.0
    first = row["first_difference"]
    assert (first["seed"], first["failed"]) == (0, "B")
    assert first["cause"]["kind"] == "never_seen"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ((*_SIDES, "--seeds", "5"), "first and the last seed"),
        ((*_SIDES, "--seeds", "9-5"), "first and the last seed"),
        ((*_SIDES, "--seeds", "0-99999999999999999999"), "at most 9 digits"),
        ((*_SIDES, "--json", "--markdown"), "exclude each other"),
        ((_SIDES[0], "reach,stage"), "expected name=value"),
        ((_SIDES[0], "reach,stage=absent,stage=football"), "'stage' is given twice"),
        ((_SIDES[0], "reach@nowhere"), "unknown revision 'nowhere'"),
    ],
)
def test_compare_of_unreadable_words_is_refused(
    words: tuple[str, ...],
    told: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert cb(monkeypatch, "compare", *words) == 2
    assert told in capsys.readouterr().err
