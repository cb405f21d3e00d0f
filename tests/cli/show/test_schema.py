"""``cb show schema``: the trees of a schema in every format, and against another."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests.cli.test_main import cb

Shown = Callable[..., str]

SCHEMA = """\
cbdsl: 1
kind: schema
name: pick
program: reachtouch
policy: reachtouch
features: {place: stereo.$feature, volume: stereo.$feature.volume}
allocations:
  right: {arm: right_arm, hand: right_hand}
  left: {arm: left_arm, hand: left_hand}
  both: {program: reachtouch_bimanual}
choose:
  if: volume > 0.012 m^3
  then: both
  else: {if: place.y > 2 cm, then: left, else: [right, left]}
otherwise: [right, left]
reward: {if: place.x > 1.02 m, then: 0.02, else: 0.97}
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    file = tmp_path / "pick.yaml"
    file.write_text(SCHEMA, encoding="utf-8")
    return file


@pytest.fixture
def shown(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Shown:
    def run(*words: object) -> str:
        assert cb(monkeypatch, "show", "schema", *map(str, words)) == 0
        return capsys.readouterr().out

    return run


def test_trees_are_reported_question_by_question(shown: Shown, file: Path) -> None:
    text = shown(file)
    assert "  place.x > 1.02 m: 2 %\n  else: 97 %" in text
    assert "volume > 0.012 m^3: both\n  else:\n    place.y > 2 cm: left" in text
    assert "else: right, then left" in text


def test_drawing_has_all_questions_and_answers(shown: Shown, file: Path) -> None:
    picture = ElementTree.fromstring(shown(file, "--format", "svg"))
    words = " ".join(picture.itertext())
    for word in ("place.x > 1.02 m ?", "volume > 0.012 m^3 ?", "reward 97 %", "both", "then left"):
        assert word in words
    assert "not active" not in words, "there are no states in it"
    assert shown(file, "--format", "mermaid").startswith("flowchart")
    assert json.loads(shown(file, "--json"))["choose"]["then"] == "both"


def test_another_schema_differs_by_its_lines(shown: Shown, file: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.yaml"
    other.write_text(SCHEMA.replace("place.y > 2 cm", "place.y > 5 cm"), encoding="utf-8")
    lines = shown(other, "--against", file).splitlines()
    assert [line for line in lines if line[0] in "+-"] == [
        "-    place.y > 2 cm: left",
        "+    place.y > 5 cm: left",
    ]
    assert shown(file, "--against", file) == "no difference\n"


def test_schema_with_an_unsuitable_substitute_is_refused(
    file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "validate", str(file)) == 0
    file.write_text(SCHEMA.replace("reachtouch_bimanual", "bimanualtouch"), encoding="utf-8")
    assert cb(monkeypatch, "validate", str(file)) == 1
    told = " ".join(capsys.readouterr().out.split())
    assert "CB634" in told and "its actions are not those of 'reachtouch'" in told
    file.write_text(SCHEMA.replace("reachtouch_bimanual", "nonesuch"), encoding="utf-8")
    assert cb(monkeypatch, "validate", str(file)) == 1
    assert "no valid program 'nonesuch'" in " ".join(capsys.readouterr().out.split())
