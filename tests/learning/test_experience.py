"""Rows of journals: lines that earlier versions wrote are read, and written again unchanged."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from cbdsl.learning.catalogs.action_outcome import ACTIONS
from cbdsl.learning.experience import EPISODES
from cbdsl.storage.journal import RowForm

STEP = (
    '{"program": "reachtouch", "depth": 0, "time": 1.25, "state": "XX", "action": "searchtrack",'
    ' "next_state": "X1", "ticks": 25, "reward": 1, "rewarding": ["touch"]}'
)
EPISODE = (
    '{"context": "in_view", "seed": 7, "transitions": [' + STEP + "],"
    ' "rewarded": {"right_arm": [0.5, -0.25]}, "ticks": 25, "sim_seconds": 1.25,'
    ' "wall_seconds": 0.125}'
)
ACTION = (
    '{"action": "reach", "rewarded": true, "features": {"place": [0.5, 0.25, 0.125]},'
    ' "opened": ["mark_blue"], "ahead": {"reach": {"place": [0.5, 0.25, 0.125]}},'
    ' "ending": "Rewarded after 1.2 s.", "failed": false, "sim_seconds": 1.25}'
)
#: Fields that later versions add to a row, with the values of a row that lacks them.
LATER: dict[str, object] = {
    "allocation": "",
    "features": {},
    "reason": "",
    "stuck": [],
    "use": "",
    "wall_seconds": 0.0,
}


@pytest.mark.parametrize(("form", "line"), [(EPISODES, EPISODE), (ACTIONS, ACTION)])
def test_row_form_reads_a_line_of_an_earlier_version_and_keeps_its_fields(
    form: RowForm[Any], line: str
) -> None:
    old = json.loads(line)
    new = json.loads(json.dumps(form.write(form.parse(old, Path("old.jsonl"), 2))))
    assert _without_later(new, old) == old


def test_experience_of_an_earlier_line_has_its_reward_and_end() -> None:
    experience = EPISODES.parse(json.loads(EPISODE), Path("old.jsonl"), 2)
    assert (experience.reward, experience.rewarding, experience.end) == (1, ("touch",), "X1")
    assert experience.rewarded == {"right_arm": (0.5, -0.25)} and not experience.profile.tests


def _without_later(new: Any, old: Any) -> Any:
    """Return new data without the fields that only later versions have, at their neutral values."""
    if isinstance(new, list):
        return [_without_later(one, other) for one, other in zip(new, old, strict=True)]
    if not isinstance(new, dict):
        return new
    added = {key: value for key, value in new.items() if key not in old}
    assert all(LATER[key] == value for key, value in added.items())
    return {key: _without_later(value, old[key]) for key, value in new.items() if key in old}
