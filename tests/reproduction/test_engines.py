"""Engines are compared with the first one, part by part."""

from __future__ import annotations

import pytest

from cbdsl.reproduction import engines
from cbdsl.reproduction.quantity import Verdict
from cbdsl.runtime.episode import EpisodeResult


def episode(seed: int, rewarded: bool, last: str) -> EpisodeResult:
    states, took = ("X", last), (60, 1.0, 0.25)
    head = ("reach", "table", "only", seed, rewarded)
    return EpisodeResult(*head, states, ("move",), *took, "nothing", "Done.")


def test_a_share_that_is_not_clearly_lower_agrees_and_a_lower_one_does_not() -> None:
    good = [episode(seed, True, "1") for seed in range(20)]
    worse = [episode(seed, seed >= 2, "1") for seed in range(20)]
    bad = [episode(seed, False, "0") for seed in range(20)]
    first, second, third, fourth = engines._SETUPS
    played = {first: {"reach": good}, second: {"reach": list(good)}}
    rows = list(engines._quantities({**played, third: {"reach": worse}, fourth: {"reach": bad}}))
    assert [row.ours for row in rows] == pytest.approx([100.0, 100.0, 90.0, 0.0])
    assert [row.verdict for row in rows] == [
        Verdict.NOT_JUDGED,
        Verdict.REPRODUCED,
        Verdict.UNDECIDED,
        Verdict.MISSED,
    ]
    assert "same states in 0; 1.0 s simulated, 4.0 times real time" in rows[3].note
    assert rows[1].source == "bullet: 100 %"


def test_every_program_and_policy_of_the_robot_takes_part() -> None:
    from cbdsl.yaml_text.library import Library, shipped

    names = [part.name for part in engines._parts(Library(shipped()))]
    assert {"reachtouch", "transport_hand", "policy reachtouch", "policy searchtrack"} <= set(names)
    assert not {"sixaxis_reach", "desk_reach"} & set(names)
