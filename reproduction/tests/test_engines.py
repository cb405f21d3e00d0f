"""Comparison of engines with the first one, part by part."""

from __future__ import annotations

import pytest

from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl_reproduction import engines
from cbdsl_reproduction.kept_episodes import PlayedEpisode
from cbdsl_reproduction.quantity import Verdict


def episode(seed: int, done: bool, last: str, slip: float | None = None) -> PlayedEpisode:
    states, took = ("X", last), (60, 1.0, 0.25)
    head = ("reach", "table", "only", seed, done)
    result = EpisodeResult(*head, states, ("move",), *took, "nothing", "Done.")
    return PlayedEpisode(result, done, slip)


def test_share_that_is_not_clearly_lower_agrees_and_a_lower_one_does_not() -> None:
    good = [episode(seed, True, "1") for seed in range(20)]
    worse = [episode(seed, seed >= 2, "1") for seed in range(20)]
    bad = [episode(seed, False, "0", 0.001 * seed) for seed in range(20)]
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
    assert rows[0].note == "20 of 20; 1.0 s simulated in 0.25 s"
    assert "same states in 0; 1.0 s simulated in 0.25 s" in rows[3].note
    assert "slips 9.5 mm, at most 19.0 mm" in rows[3].note
    assert rows[3].note.endswith("20 of 20 others end in 0")
    assert rows[1].claim.report == "bullet: 100 %"


def test_program_that_never_succeeds_on_the_reference_is_not_judged() -> None:
    never = [episode(seed, False, "0") for seed in range(20)]
    played = {setup: {"follow": list(never)} for setup in engines._SETUPS}
    rows = list(engines._quantities(played))
    assert {row.verdict for row in rows} == {Verdict.NOT_JUDGED}


@pytest.mark.parametrize("setup", engines._SETUPS[2:], ids=str)
def test_slip_of_a_carried_object_is_measured_in_the_frame_of_the_hand(
    setup: engines.EngineSetup,
) -> None:
    body = engines.EmbodiedRobot(setup)
    parts = {part.name: part for part in engines._parts()}
    lifted = body.player(parts["pick_and_lift"])(4_210_003)
    reached = body.player(parts["reach"])(4_210_003)
    body.backend.close()
    assert lifted.done and lifted.slip is not None and 0.0 < lifted.slip < 0.02
    assert reached.done and not reached.result.rewarded and reached.slip is None


def test_every_program_and_policy_of_the_robot_takes_part() -> None:
    names = [part.name for part in engines._parts()]
    assert {"reachtouch", "transport_hand", "policy reachtouch", "policy searchtrack"} <= set(names)
    assert {"pick", "poise"} & set(names) == {"pick"}


def test_parts_are_distinguished_by_policy_and_engine() -> None:
    from cbdsl.api.shipped import shipped_robot

    robot, _ = shipped_robot("dexter")
    parts = list(engines._parts())
    digests = {part.digest_with(robot, setup) for part in parts for setup in engines._SETUPS}
    assert len(digests) == len(parts) * len(engines._SETUPS)
