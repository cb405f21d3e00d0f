"""Journals of explorations that others join, and the lines that have to stay in them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from cbdsl.learning.catalogs.action_outcome import ActionOutcome
from cbdsl.storage.journal import JournalError
from cbdsl.training.exploration.exploration_phases import Joined, open_journal, phase


def identity(policy: str = "a", **programs: str) -> dict[str, Any]:
    return {
        "programs": {name: {"name": name, "sha256": sha} for name, sha in programs.items()},
        "policies": {"reachtouch": policy},
        "stage": {"name": "table", "sha256": "0"},
        "seed": 1,
    }


@pytest.fixture
def path(tmp_path: Path) -> Path:
    file = tmp_path / "kept.actions.jsonl"
    with open_journal(file, identity(look="1")) as journal:
        journal.append(ActionOutcome("look"))
    return file


def test_phases_count_actions_before_each_joined_program(path: Path) -> None:
    both = identity(look="1", reach="2")
    with open_journal(path, both, joins=True) as journal:
        journal.append(ActionOutcome("reach"))
    with open_journal(path, both) as journal:
        look, joined, reach = journal.rows
        assert (look, reach) == (ActionOutcome("look"), ActionOutcome("reach"))
        assert isinstance(joined, Joined)
        assert phase(1, joined.parts).programs == ("look", "reach")
        assert phase(0, journal.identity).programs == ("look",)


@pytest.mark.parametrize(
    "other",
    [identity(reach="2"), identity(look="other", reach="2"), identity("b", look="1", reach="2")],
    ids=["left", "changed", "with another policy"],
)
def test_earlier_actions_of_a_joined_exploration_cannot_change(
    path: Path, other: dict[str, Any]
) -> None:
    before = path.read_text()
    with pytest.raises(JournalError, match="the earlier programs and policies remain"):
        open_journal(path, other, joins=True)
    assert path.read_text() == before


def test_joined_exploration_with_another_seed_is_refused(path: Path) -> None:
    with pytest.raises(JournalError, match="seed was 1, is 2"):
        open_journal(path, {**identity(look="1", reach="2"), "seed": 2}, joins=True)
