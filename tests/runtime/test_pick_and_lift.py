"""``pick_and_lift``: the reaction of a hand whose grasp fails."""

from __future__ import annotations

import pytest

from cbdsl.runtime.tick import Tick
from tests.conftest import Checked
from tests.runtime.conftest import GRIP, TABLE_BALL, Play
from tests.runtime.synthetic import Ball, World

FINGERS = [f"right_finger_{number}" for number in (1, 2, 3)]


def test_empty_hand_opens_before_the_next_attempt(checked: Checked, play: Play) -> None:
    flexions: list[tuple[str, float]] = []

    def note(tick: Tick) -> None:
        joints = tick.signals.joints.pick(FINGERS)
        flexions.append((tick.run.state, float(tick.observation.positions[joints].min())))

    def direct(world: World, time: float) -> None:
        """Provide a contact once the hand has closed without success."""
        if flexions and flexions[-1][0] == "-XXXXX":
            world.contact_angle = GRIP

    program = checked("pick_and_lift", feature="sat_10")
    played = play(program, lambda rng: World(Ball(TABLE_BALL)), direct, watch=note)
    states = [each.next_state for each in played.at(0)]
    first = states.index("-XXXXX")
    assert states[first : first + 4] == ["-XXXXX", "XXXXX0", "XXXXX1", "0XXXXX"]
    assert max(angle for state, angle in flexions if state == "0XXXXX") > 1.5
    opened = next(angle for state, angle in flexions if state == "XXXXX1")
    assert opened == pytest.approx(0.2, abs=0.05)
    assert played.result.outcome == "success"
