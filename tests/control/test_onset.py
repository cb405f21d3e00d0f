"""Contact is a load that has changed for long enough, while the hand moves slowly."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.control.onset import ONSET, OnsetForm, note_load, restart_onset
from cbdsl.control.signal import Floats
from cbdsl.numeric.compiled import compiled_once

PERIOD = 1 / 60
WEIGHT = np.array([0.1, -0.2, 2.5])
DOWN = np.array([0.0, 0.0, -1.0])


@compiled_once
def note(onsets: np.ndarray, load: Floats, tip: Floats) -> bool:
    return note_load(onsets[0], load, tip)


@compiled_once
def restart(onsets: np.ndarray) -> None:
    restart_onset(onsets[0])


class Waiting:
    """A wait for 1 N less, as a tick has it; the hand moves at a speed, m/s."""

    def __init__(self, window: float = 0.05, along: Floats = DOWN) -> None:
        form = OnsetForm(1.0, along, window, 0.1, 0, PERIOD)
        self.state = np.array([form.record()], ONSET)
        self._tip = np.zeros(3)
        self._rng = np.random.default_rng(4)

    def ticks(self, load: Floats, seconds: float, speed: float = 0.05) -> float | None:
        """When the load was found to have changed, s; ``None`` if it was not."""
        for tick in range(round(seconds / PERIOD)):
            self._tip = self._tip - [0.0, 0.0, speed * PERIOD]
            noisy = load + self._rng.normal(0, 0.03 * 3**0.5, 3)
            if note(self.state, noisy, self._tip):
                return tick * PERIOD
        return None


@pytest.mark.parametrize("seconds", [0.2, 0.5, 10.0])
def test_a_lasting_drop_is_contact_and_the_mean_is_the_weight(seconds: float) -> None:
    waiting = Waiting()
    assert waiting.ticks(WEIGHT, seconds) is None
    after = waiting.ticks(WEIGHT - [0, 0, 2.0], 1.0)
    assert after is not None and after < 0.15
    np.testing.assert_allclose(waiting.state["mean"][0], WEIGHT, atol=0.15)


def test_a_load_that_is_there_from_the_beginning_has_not_changed() -> None:
    waiting = Waiting(along=-DOWN)
    assert waiting.ticks(WEIGHT, 1.0) is None
    after = waiting.ticks(WEIGHT - [0, 0, -2.0], 1.0)
    assert after is not None and after < 0.15


def test_a_rise_a_push_aside_and_a_short_drop_are_no_contact() -> None:
    waiting = Waiting()
    waiting.ticks(WEIGHT, 1.0)
    assert waiting.ticks(WEIGHT - [0, 0, -3.0], 0.3) is None
    assert waiting.ticks(WEIGHT, 1.0) is None
    assert waiting.ticks(WEIGHT - [3.0, 3.0, 0], 0.3) is None
    assert waiting.ticks(WEIGHT - [0, 0, 2.0], 0.04) is None
    assert waiting.ticks(WEIGHT, 1.0) is None


def test_a_drop_while_the_hand_moves_fast_is_no_contact() -> None:
    waiting = Waiting()
    waiting.ticks(WEIGHT, 1.0, speed=0.3)
    assert waiting.ticks(WEIGHT - [0, 0, 2.0], 0.3, speed=0.3) is None


def test_a_load_that_changes_slowly_is_another_weight() -> None:
    waiting = Waiting()
    waiting.ticks(WEIGHT, 1.0)
    for step in np.linspace(0, 2, 60):
        assert waiting.ticks(WEIGHT - [0, 0, step], 0.1) is None


def test_after_a_restart_the_load_is_new() -> None:
    waiting = Waiting()
    waiting.ticks(WEIGHT, 1.0)
    restart(waiting.state)
    assert waiting.ticks(WEIGHT - [0, 0, 2.0], 1.0) is None
    np.testing.assert_allclose(waiting.state["mean"][0], WEIGHT - [0, 0, 2.0], atol=0.1)
