"""Gates of force: shipped programs are rewarded only within a fifth of a reference."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from tests.conftest import ROOT

WIDEST = 0.2
#: PLACE presses with 2 N of a weight that swings in the hand: it came to rest 0.5 N off.
PRESSING = {"bring": 0.5, "pick_and_place": 0.5, "set_on": 0.5}
FILES = sorted([*(ROOT / "programs").glob("*.yaml"), *(ROOT / "robots").glob("*.yaml")])


def shares(section: object, key: str = "") -> list[float]:
    """Return all ``within`` of quiescences in a document, at any depth."""
    if isinstance(section, list):
        return [share for each in section for share in shares(each)]
    if not isinstance(section, dict):
        return []
    own = [float(section["within"])] if key == "quiescence" and "within" in section else []
    return own + [share for name, each in section.items() for share in shares(each, name)]


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_no_gate_is_wider_than_a_fifth(file: Path) -> None:
    widest = PRESSING.get(file.stem, WIDEST)
    assert all(share <= widest for share in shares(yaml.safe_load(file.read_text())))


def test_there_are_gates() -> None:
    assert sum(len(shares(yaml.safe_load(file.read_text()))) for file in FILES) > 5
