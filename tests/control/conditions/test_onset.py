"""Contact is a load that has changed for long enough, while the hand moves slowly."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.control.conditions.onset import ONSET, OnsetForm, note_load, restart_onset
from cbdsl.numeric.arrays import Floats
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
        """Return the time at which a change of the load was found, s; ``None`` if it was not."""
        for tick in range(round(seconds / PERIOD)):
            self._tip = self._tip - [0.0, 0.0, speed * PERIOD]
            noisy = load + self._rng.normal(0, 0.03 * 3**0.5, 3)
            if note(self.state, noisy, self._tip):
                return tick * PERIOD
        return None


@pytest.mark.parametrize("seconds", [0.2, 0.5, 10.0])
def test_lasting_drop_is_contact_and_the_mean_is_the_weight(seconds: float) -> None:
    waiting = Waiting()
    assert waiting.ticks(WEIGHT, seconds) is None
    after = waiting.ticks(WEIGHT - [0, 0, 2.0], 1.0)
    assert after is not None and after < 0.15
    np.testing.assert_allclose(waiting.state["mean"][0], WEIGHT, atol=0.15)


def test_load_that_is_there_from_the_beginning_has_not_changed() -> None:
    waiting = Waiting(along=-DOWN)
    assert waiting.ticks(WEIGHT, 1.0) is None
    after = waiting.ticks(WEIGHT - [0, 0, -2.0], 1.0)
    assert after is not None and after < 0.15


def test_rise_a_push_aside_and_a_short_drop_are_no_contact() -> None:
    waiting = Waiting()
    waiting.ticks(WEIGHT, 1.0)
    assert waiting.ticks(WEIGHT - [0, 0, -3.0], 0.3) is None
    assert waiting.ticks(WEIGHT, 1.0) is None
    assert waiting.ticks(WEIGHT - [3.0, 3.0, 0], 0.3) is None
    assert waiting.ticks(WEIGHT - [0, 0, 2.0], 0.04) is None
    assert waiting.ticks(WEIGHT, 1.0) is None


def test_drop_while_the_hand_moves_fast_is_no_contact() -> None:
    waiting = Waiting()
    waiting.ticks(WEIGHT, 1.0, speed=0.3)
    assert waiting.ticks(WEIGHT - [0, 0, 2.0], 0.3, speed=0.3) is None


def test_load_that_changes_slowly_is_another_weight() -> None:
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


class Carrying(Waiting):
    """A wait for 1 N less of a load of at least 0.15 N that was lifted by 3 cm."""

    def __init__(self) -> None:
        super().__init__()
        form = OnsetForm(1.0, DOWN, 0.05, 0.1, 0, PERIOD, 0.15, 0.03)
        self.state = np.array([form.record()], ONSET)


HANGING = np.array([0.03, -0.04, 2.45])


@pytest.mark.parametrize(
    ("load", "rise", "is_contact"),
    [
        pytest.param(HANGING, 0.05, True, id="hanging, lifted"),
        pytest.param(HANGING, 0.02, False, id="hanging, not lifted"),
        pytest.param(HANGING, -0.05, False, id="hanging, lowered"),
        pytest.param(-HANGING, 0.05, False, id="pressing on a table"),
        pytest.param(0.02 * HANGING, 0.05, False, id="nothing in the hand"),
        pytest.param(HANGING + np.array([0.5, 0.0, 0.0]), 0.05, False, id="dragged"),
        pytest.param(0.1 * HANGING, 0.05, True, id="25 g"),
    ],
)
def test_note_load_counts_only_a_load_that_hung_in_the_hand_and_was_lifted(
    load: Floats, rise: float, is_contact: bool
) -> None:
    carrying = Carrying()
    carrying.ticks(load, 1.0, speed=-rise)
    after = carrying.ticks(load - [0.0, 0.0, 2.0], 0.5)
    assert (after is not None) == is_contact


def test_note_load_resets_a_lift_without_a_load() -> None:
    carrying = Carrying()
    carrying.ticks(HANGING, 1.0, speed=-0.05)
    for share in np.linspace(1.0, 0.0, 40):
        assert carrying.ticks(share * HANGING, 0.3, speed=0.0) is None
    carrying.ticks(HANGING, 2.0, speed=0.0)
    assert carrying.ticks(HANGING - [0.0, 0.0, 2.0], 0.5) is None
